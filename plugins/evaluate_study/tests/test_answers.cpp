#include "answers.h"
#include "catch.h"
#include "small_study.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/value.h>

#include <functional>

using namespace study;
using Catch::Contains;
using fresco::Value;

namespace
{

Value answer(int question, int left, int right, const char* choice)
{
    return Value::Map{{"question", question}, {"left", left}, {"right", right}, {"choice", choice}, {"seconds", 1.5}};
}

Value sheet(const std::string& participant)
{
    return Value::Map{{"format", "fresco.study_answers"},
                      {"version", 1},
                      {"study", small_study().id},
                      {"participant", participant},
                      {"complete", false},
                      {"answers", Value::List{answer(0, 0, 2, "left"), answer(1, 2, 0, "neither"), answer(1, 4, 5, "right")}}};
}

/// What is said of the sheet once `change` was made to it.
std::string error_of(const std::function<void(Value&)>& change)
{
    Value value = sheet("Ann-1");
    change(value);
    try
    {
        sheet_from(fresco::to_json(value), "ann.json", small_study());
    }
    catch (const fresco::Error& error)
    {
        return error.what();
    }
    return "";
}

Value& first_answer(Value& value)
{
    return value.find("answers")->as_list().front();
}

}  // namespace

TEST_CASE("a sheet is read as the page wrote it")
{
    const AnswerSheet read = sheet_from(fresco::to_json(sheet("Ann-1")), "ann.json", small_study());
    CHECK(read.participant == "Ann-1");
    CHECK_FALSE(read.complete);
    REQUIRE(read.answers.size() == 3);
    CHECK(read.answers[0].choice == Choice::left);
    CHECK(read.answers[1].question == 1);
    CHECK(read.answers[1].left == 2);
    CHECK(read.answers[1].choice == Choice::neither);
    CHECK(read.answers[2].right == 5);
    CHECK(read.answers[2].choice == Choice::right);
    CHECK(read.answers[2].seconds == 1.5);
}

TEST_CASE("answers that cannot be are refused by file and entry")
{
    CHECK(error_of([](Value&) {}).empty());
    const auto set = [](const char* key, const Value& value) { return error_of([&](Value& root) { root.set(key, value); }); };
    const auto set_first = [](const char* key, const Value& value)
    { return error_of([&](Value& root) { first_answer(root).set(key, value); }); };
    CHECK_THAT(set("format", "other"), Contains("ann.json: not the answers of a study, version 1"));
    CHECK_THAT(set("version", 2), Contains("not the answers of a study, version 1"));
    CHECK_THAT(set("study", "ffff"), Contains("ann.json: answers of another study; move the file away"));
    CHECK_THAT(set("participant", "a b"), Contains("participant: expected 1 to 40 letters"));
    CHECK_THAT(set("participant", ""), Contains("participant"));
    CHECK_THAT(set("complete", 1), Contains("ann.json: expected"));
    CHECK_THAT(set("more", 1), Contains("\"more\" is not known"));
    CHECK_THAT(set_first("question", 2), Contains("ann.json: answers[0]: question: 2; the study has 2"));
    CHECK_THAT(set_first("left", 6), Contains("answers[0]: left: 6; the study has 6"));
    CHECK_THAT(set_first("left", -1), Contains("answers[0]: left"));
    CHECK_THAT(set_first("left", 1), Contains("the pictures 1 and 2 are not a pair"));  // another view
    CHECK_THAT(set_first("left", 2), Contains("the pictures 2 and 2 are not a pair"));  // the same picture
    CHECK_THAT(set_first("choice", "both"), Contains("left, right or neither"));
    CHECK_THAT(set_first("seconds", -1), Contains("seconds"));
    CHECK_THAT(set_first("seconds", "1"), Contains("answers[0]: expected"));
    CHECK_THAT(error_of([](Value& root) { root.find("answers")->as_list().push_back(answer(0, 2, 0, "right")); }),
               Contains("answers[3]: this pair is answered twice"));
    CHECK_THROWS_WITH(sheet_from("{", "ann.json", small_study()), Contains("ann.json: not valid JSON"));
    Study short_study = small_study();
    short_study.pairs_count = 2;
    CHECK_THROWS_WITH(sheet_from(fresco::to_json(sheet("Ann-1")), "ann.json", short_study), Contains("3; expected at most 2"));
}

TEST_CASE("sheets come in the order of their participants, each of whom has one")
{
    const fresco::testing::TemporaryFolder folder;
    const auto write = [&](const char* name, const std::string& participant)
    {
        fresco::write_file(folder.path() / name, fresco::to_json(sheet(participant)));
        return folder.path() / name;
    };
    const auto z = write("1.json", "zoe");
    const auto a = write("2.json", "ann");
    const auto sheets = read_sheets({z, a}, small_study());
    REQUIRE(sheets.size() == 2);
    CHECK(sheets[0].participant == "ann");
    CHECK(sheets[1].participant == "zoe");
    const auto again = write("3.json", "ann");
    CHECK_THROWS_WITH(read_sheets({z, a, again}, small_study()),
                      Contains("3.json and") && Contains("2.json are answers of the same participant, ann: keep one"));
}
