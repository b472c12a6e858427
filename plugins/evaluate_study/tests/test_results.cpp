#include "catch.h"
#include "results.h"
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
    CHECK_THAT(set("complete", 1), Contains("ann.json: complete: expected"));
    CHECK_THAT(set("more", 1), Contains("ann.json: unknown entry 'more'"));
    CHECK_THAT(set_first("question", 2), Contains("ann.json: answers[0].question: 2; the study has 2"));
    CHECK_THAT(set_first("left", 6), Contains("answers[0].left: 6; the study has 6"));
    CHECK_THAT(set_first("left", -1), Contains("answers[0].left"));
    CHECK_THAT(set_first("left", 1), Contains("the pictures 1 and 2 are not a pair"));  // another view
    CHECK_THAT(set_first("left", 2), Contains("the pictures 2 and 2 are not a pair"));  // the same picture
    CHECK_THAT(set_first("choice", "both"), Contains("left, right or neither"));
    CHECK_THAT(set_first("seconds", -1), Contains("seconds"));
    CHECK_THAT(set_first("seconds", "1"), Contains("answers[0].seconds: expected"));
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

namespace
{

/// So many views by the methods a (even numbers) and b.
Study plain_study(std::size_t views)
{
    Study study;
    study.questions = {"Which?"};
    study.pairs_count = 1000;
    for (std::size_t i = 0; i < views; ++i)
        for (const char* method : {"a", "b"})
            study.pictures.push_back({method, std::to_string(i)});
    return study;
}

/// A participant who chose a, then b, then neither so many times; a is on the left of every other pair.
AnswerSheet sheet(const std::string& participant, int a, int b, int neither)
{
    AnswerSheet result{participant, true, {}};
    for (int i = 0; i < a + b + neither; ++i)
    {
        const bool swapped = i % 2 == 1;
        const auto number = static_cast<std::size_t>(2 * i);
        const bool left = swapped == (i >= a);
        const Choice choice = i >= a + b ? Choice::neither : left ? Choice::left : Choice::right;
        result.answers.push_back({0, swapped ? number + 1 : number, swapped ? number : number + 1, choice, 1});
    }
    return result;
}

const fresco::evaluation::Bootstrap usual{.resamples = 2000, .seed = 1};

}  // namespace

TEST_CASE("shares and their intervals as worked out by hand")
{
    // Four unanimous participants of three answers: draws never vary, so that Wilson's 12 of 12 remains, 12 / (12 + z²).
    const std::vector<AnswerSheet> unanimous{sheet("1", 3, 0, 0), sheet("2", 3, 0, 0), sheet("3", 3, 0, 0), sheet("4", 3, 0, 0)};
    const auto clear = verdicts(plain_study(10), unanimous, usual);
    REQUIRE(clear.size() == 1);
    CHECK(clear[0].first == "a");
    CHECK(clear[0].second == "b");
    CHECK(clear[0].participants == 4);
    CHECK(clear[0].answers == 12);
    CHECK(clear[0].shares[0].value == 1);
    CHECK(clear[0].shares[0].interval.low == Approx(12 / (12 + 1.959964 * 1.959964)).epsilon(1e-6));
    CHECK(clear[0].shares[0].interval.high == 1);
    CHECK(clear[0].shares[1].count == 0);
    CHECK(clear[0].shares[1].interval.low == 0);
    CHECK(clear[0].preferred == "a");

    // Two who contradict each other: a quarter of the draws is the one alone, a quarter the other alone. Twenty independent
    // answers would have given [0.30, 0.70].
    const auto divided = verdicts(plain_study(10), {sheet("1", 10, 0, 0), sheet("2", 0, 10, 0)}, usual);
    CHECK(divided[0].shares[0].value == 0.5);
    CHECK(divided[0].shares[0].interval.low == 0);
    CHECK(divided[0].shares[0].interval.high == 1);
    CHECK(divided[0].preferred.empty());
}

TEST_CASE("an order is claimed only where the intervals are apart and two took part")
{
    std::vector<AnswerSheet> sheets;
    for (int i = 0; i < 10; ++i)
        sheets.push_back(sheet(std::to_string(i), 2, 5, 3));
    auto found = verdicts(plain_study(10), sheets, usual);
    // 20 and 50 of 100, no difference between participants: Wilson's [0.133, 0.289] and [0.404, 0.596].
    CHECK(found[0].shares[0].interval.low == Approx(0.1334).margin(1e-4));
    CHECK(found[0].shares[0].interval.high == Approx(0.2888).margin(1e-4));
    CHECK(found[0].shares[1].interval.low == Approx(0.4038).margin(1e-4));
    CHECK(found[0].shares[2].count == 30);
    CHECK(found[0].preferred == "b");

    for (AnswerSheet& one : sheets)
        one = sheet(one.participant, 3, 4, 3);
    CHECK(verdicts(plain_study(10), sheets, usual)[0].preferred.empty());
    CHECK(verdicts(plain_study(100), {sheet("1", 90, 0, 0)}, usual)[0].preferred.empty());
    CHECK(verdicts(plain_study(100), {sheet("1", 45, 0, 0), sheet("2", 45, 0, 0)}, usual)[0].preferred == "a");
}

TEST_CASE("answers count for their question and their two methods")
{
    const Study study = small_study();
    // a by number 2 and b by 0 show view one; b by 5 and c by 4 show view three.
    const std::vector<AnswerSheet> sheets{{"1", true, {{0, 0, 2, Choice::left, 1}, {1, 2, 0, Choice::left, 1}}},
                                          {"2", true, {{0, 4, 5, Choice::neither, 1}, {0, 1, 3, Choice::right, 1}}}};
    const auto found = verdicts(study, sheets, usual);
    REQUIRE(found.size() == 3);
    CHECK(found[0].question == 0);
    CHECK(found[0].second == "b");
    CHECK(found[0].shares[1].count == 2);  // b, once from the left and once from the right
    CHECK(found[0].participants == 2);
    CHECK(found[1].first == "b");
    CHECK(found[1].second == "c");
    CHECK(found[1].shares[2].count == 1);
    CHECK(found[1].participants == 1);
    CHECK(found[2].question == 1);
    CHECK(found[2].shares[0].count == 1);
    CHECK(verdicts(study, {}, usual).empty());
}

namespace
{

Verdict verdict(std::size_t question, std::string preferred)
{
    return {.question = question,
            .first = "ours",
            .second = "theirs",
            .participants = 2,
            .answers = 4,
            .shares = {Share{3, 0.75, {0.5, 0.9}}, Share{1, 0.25, {0.1, 0.4}}, Share{0, 0, {0, 0.3}}},
            .preferred = std::move(preferred)};
}

}  // namespace

TEST_CASE("a verdict fits on a line")
{
    Study study;
    study.questions = {"Sharper?", "Nicer?"};
    CHECK(verdict_line(study, verdict(1, "ours")) == "Nicer? ours 75.0 % [50.0, 90.0], theirs 25.0 % [10.0, 40.0], neither 0.0 % "
                                                     "[0.0, 30.0] of 4 answers: ours is chosen more often");
    CHECK(verdict_line(study, verdict(0, "")).ends_with(": no significant preference"));
}

TEST_CASE("verdicts are listed under their questions, and answers are counted")
{
    Study study;
    study.id = "id";
    study.questions = {"Sharper?", "Nicer?"};
    std::vector<AnswerSheet> sheets(2);
    sheets[0].complete = true;
    sheets[0].answers.resize(2);
    sheets[0].answers[0].seconds = 2;
    sheets[0].answers[1].seconds = 4;
    const Value told = results_value(study, sheets, {verdict(1, "ours"), verdict(1, "")});
    CHECK(told.at("participants").as_int() == 2);
    CHECK(told.at("complete").as_int() == 1);
    CHECK(told.at("answers").as_int() == 2);
    CHECK(told.at("mean_seconds").as_double() == 3);
    const auto& questions = told.at("questions").as_list();
    REQUIRE(questions.size() == 2);
    CHECK(questions[0].at("comparisons").as_list().empty());
    const auto& compared = questions[1].at("comparisons").as_list();
    REQUIRE(compared.size() == 2);
    CHECK(compared[0].at("preferred").as_string() == "ours");
    CHECK(compared[1].at("preferred").is_null());
    CHECK(compared[0].at("first_share").at("count").as_int() == 3);
    CHECK(results_value(study, {}, {}).at("mean_seconds").is_null());
}
