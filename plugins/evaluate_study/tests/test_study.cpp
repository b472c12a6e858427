#include "catch.h"
#include "page.h"
#include "results.h"
#include "study.h"

#include <fresco/files_io.h>
#include <fresco/testing.h>
#include <fresco/value.h>

#include <functional>
#include <set>

using namespace study;
using Catch::Contains;
using fresco::Value;

namespace
{

/// Two views by the methods a and b, one more by b and c; two questions. Numbers as they stand here.
Study small_study()
{
    Study study;
    study.id = "0123456789abcdef0123456789abcdef";
    study.questions = {"Sharper?", "Brighter?"};
    study.pictures = {{"b", "one"}, {"a", "two"}, {"a", "one"}, {"b", "two"}, {"c", "three"}, {"b", "three"}};
    study.pairs_count = 6;
    return study;
}

std::vector<Group> two_groups(const std::filesystem::path& folder)
{
    std::vector<Group> groups;
    for (const char* name : {"one", "two"})
    {
        Group group{name, {}};
        for (const char* method : {"a", "b"})
        {
            group.files[method] = folder / (std::string(name) + method);
            fresco::write_file(group.files[method], std::string(name) + method);
        }
        groups.push_back(group);
    }
    return groups;
}

}  // namespace

TEST_CASE("pictures of equal names are compared, so many of them at most, evenly spread")
{
    MethodPictures a{"a", {}};
    MethodPictures b{"b", {}};
    for (int i = 0; i < 10; ++i)
    {
        a.files["view-" + std::to_string(i)] = "a" + std::to_string(i);
        b.files["view-" + std::to_string(i + 2)] = "b" + std::to_string(i);
    }
    const auto all = compared_groups({a, b}, 100);
    REQUIRE(all.size() == 8);
    CHECK(all[0].name == "view-2");
    CHECK(all[0].files.at("a") == "a2");
    CHECK(all[0].files.at("b") == "b0");
    const auto some = compared_groups({a, b}, 2);
    REQUIRE(some.size() == 2);
    // The middles of two halves.
    CHECK(some[0].name == "view-4");
    CHECK(some[1].name == "view-8");

    CHECK_THROWS_WITH(compared_groups({}, 5), Contains("found none"));
    CHECK_THROWS_WITH(compared_groups({a}, 5), Contains("found one"));
    CHECK_THROWS_WITH(compared_groups({a, a}, 5), Contains("two methods are named a"));
    MethodPictures other{"other", {{"x", "x.png"}}};
    CHECK_THROWS_WITH(compared_groups({a, other}, 5), Contains("a has view-0, … and other has x;"));
}

TEST_CASE("a study's id is of all that it is made of, its numbers of the seed")
{
    const fresco::testing::TemporaryFolder folder;
    auto groups = two_groups(folder.path());
    const Study made = make_study(groups, {"Which?"}, 5, {}, 1, "960jpeg90");
    CHECK(made.id.size() == 32);
    CHECK(made.id == make_study(groups, {"Which?"}, 5, {}, 1, "960jpeg90").id);
    std::set<std::pair<std::string, std::string>> pictures;
    for (const Picture& picture : made.pictures)
        pictures.emplace(picture.method, picture.name);
    CHECK(pictures == std::set<std::pair<std::string, std::string>>{{"a", "one"}, {"b", "one"}, {"a", "two"}, {"b", "two"}});
    bool other_order = false;
    for (std::uint64_t seed = 2; seed < 6; ++seed)
        other_order = other_order || !(make_study(groups, {"Which?"}, 5, {}, seed, "960jpeg90").pictures == made.pictures);
    CHECK(other_order);

    std::set<std::string> ids{made.id};
    CHECK(ids.insert(make_study(groups, {"Why?"}, 5, {}, 1, "960jpeg90").id).second);
    CHECK(ids.insert(make_study(groups, {"Which?"}, 6, {}, 1, "960jpeg90").id).second);
    CHECK(ids.insert(make_study(groups, {"Which?"}, 5, {}, 1, "960png90").id).second);
    fresco::write_file(groups[1].files["b"], "repainted");
    CHECK(ids.insert(make_study(groups, {"Which?"}, 5, {}, 1, "960jpeg90").id).second);
}

TEST_CASE("questions are separated by a bar")
{
    CHECK(split_questions("One?") == std::vector<std::string>{"One?"});
    CHECK(split_questions(" One? |Two, or\nthree? \n") == std::vector<std::string>{"One?", "Two, or\nthree?"});
    CHECK_THROWS_WITH(split_questions("One? |"), Contains("a question is empty"));
    CHECK_THROWS_WITH(split_questions(""), Contains("a question is empty"));
}

TEST_CASE("a key gives the study back, and only as it was written")
{
    const Study study = small_study();
    const std::string text = key_text(study);
    const Study read = key_from(text, "study.key.json");
    CHECK(read.id == study.id);
    CHECK(read.questions == study.questions);
    CHECK(read.pictures == study.pictures);
    CHECK(read.pairs_count == 6);
    CHECK(key_text(read) == text);
    const auto changed = [&](const std::string& from, const std::string& to)
    {
        std::string other = text;
        other.replace(other.find(from), from.size(), to);
        return other;
    };
    CHECK_THROWS_WITH(key_from(changed("study_key", "other"), "k.json"), Contains("k.json: not the key of a study, version 1"));
    CHECK_THROWS_WITH(key_from(changed("\"version\": 1", "\"version\": 2"), "k.json"), Contains("version 1"));
    CHECK_THROWS_WITH(key_from(changed("\"pairs_count\"", "\"pairs\""), "k.json"), Contains("k.json: ") && Contains("pairs"));
    CHECK_THROWS_WITH(key_from(changed("\"version\": 1,", "\"version\": 1, \"more\": 2,"), "k.json"),
                      Contains("unknown entry 'more'"));
    CHECK_THROWS_WITH(key_from(changed("\"name\": \"two\"", "\"name\": \"one\""), "k.json"), Contains("one of a appears twice"));
    CHECK_THROWS_WITH(key_from("{]", "k.json"), Contains("k.json: not valid JSON"));
}

TEST_CASE("a study of one method against the others, with its questions mixed and hints")
{
    Study study = small_study();
    study.design.ours = "c";
    auto compared = comparisons(study);
    REQUIRE(compared.size() == 1);
    CHECK(compared[0].first == "b");
    CHECK(compared[0].second == "c");
    study.design.ours = "b";
    CHECK(comparisons(study).size() == 2);
    study.pictures.push_back({"c", "one"});
    CHECK(comparisons(study).size() == 2);  // c and a share a view now, but are not compared

    study.design.mixes_questions = true;
    study.design.hints = {{"one", {}, 0.25, 0, 0.5, 1}, {"two", 1, 0, 0.5, 0.125, 0.25}};
    const Study read = key_from(key_text(study), "key");
    CHECK(read.design.ours == "b");
    CHECK(read.design.mixes_questions);
    CHECK(read.design.hints == study.design.hints);

    fresco::testing::TemporaryFolder folder;
    const auto groups = two_groups(folder.path());
    const auto made = [&](Design design) { return make_study(groups, {"Which?"}, 5, std::move(design), 1, "960jpeg90").id; };
    const std::set<std::string> ids{made({}), made({"a", false, {}}), made({"", true, {}}),
                                    made({"", false, {{"one", 0, 0, 0, 1, 1}}})};
    CHECK(ids.size() == 4);
    CHECK_THROWS_WITH(made({"z", false, {}}), Contains("no method is called z"));
    CHECK_THROWS_WITH(made({"", false, {{"none", 0, 0, 0, 1, 1}}}), Contains("the view none"));
    CHECK_THROWS_WITH(made({"", false, {{"one", 3, 0, 0, 1, 1}}}), Contains("question 3"));
}

TEST_CASE("hints are read strictly")
{
    const auto read = [](const std::string& entry) { return hints_from("[{" + entry + "}]", "hints.json"); };
    const auto hints = read(R"("view": "one", "question": 1, "left": 0.5, "top": 0, "width": 0.5, "height": 0.25)");
    REQUIRE(hints.size() == 1);
    CHECK(hints[0] == Hint{"one", 1, 0.5, 0, 0.5, 0.25});
    CHECK_FALSE(read(R"("view": "one", "left": 0.5, "top": 0, "width": 0.5, "height": 0.25)")[0].question);
    for (const char* wrong :
         {R"("view": "one", "left": 0.6, "top": 0, "width": 0.5, "height": 1)",
          R"("view": "one", "left": 0, "top": 0, "width": 0, "height": 1)", R"("view": "one", "left": 0, "top": 0, "width": 1)",
          R"("view": 1, "left": 0, "top": 0, "width": 1, "height": 1)",
          R"("view": "one", "left": 0, "top": 0, "width": 1, "height": 1, "color": 1)",
          R"("view": "one", "question": -1, "left": 0, "top": 0, "width": 1, "height": 1)"})
        CHECK_THROWS_WITH(read(wrong), Contains("hints.json[0]"));
}

namespace
{

/// The data in the page, as its script reads it.
fresco::Value data_of(const std::string& text)
{
    const std::string_view mark = "id=\"study-data\">";
    const auto begin = text.find(mark) + mark.size();
    return fresco::parse_json(std::string_view(text).substr(begin, text.find("</script>", begin) - begin));
}

}  // namespace

TEST_CASE("the page holds the pictures and questions, all pairs, and no method's name")
{
    Study study = small_study();
    for (Picture& picture : study.pictures)
        picture.method = "method-" + picture.method;
    study.questions[0] = "Is </script><b>this</b> sharper?";
    const std::string text = page(study, {"data:0", "data:1", "data:2", "data:3", "data:4", "data:5"});
    CHECK(text.find("method-") == std::string::npos);
    CHECK(text.find("<!--STYLE-->") == std::string::npos);
    CHECK(text.find("<!--SCRIPT-->") == std::string::npos);
    CHECK(text.find("http://") == std::string::npos);
    CHECK(text.find("https://") == std::string::npos);
    const fresco::Value data = data_of(text);
    CHECK(data.at("study").as_string() == study.id);
    CHECK(data.at("questions").as_list().front().as_string() == study.questions[0]);
    CHECK(data.at("pictures").as_list().size() == 6);
    CHECK(data.at("pairs_count").as_int() == 6);
    // In each pair the smaller number first: the order does not tell the method.
    CHECK(data.at("strata") == fresco::parse_json("[[[0, 2], [1, 3]], [[4, 5]]]"));
    CHECK_FALSE(data.at("mixes_questions").as_bool());

    study.design = {"method-b", true, {{"two", 1, 0.5, 0, 0.25, 1}, {"one", {}, 0, 0, 1, 1}}};
    const fresco::Value changed = data_of(page(study, {"data:0", "data:1", "data:2", "data:3", "data:4", "data:5"}));
    CHECK(changed.at("mixes_questions").as_bool());
    // By picture's number: of view one 0 and 2, of two 1 and 3.
    CHECK(changed.at("hints") ==
          fresco::parse_json("[[[null, 0.0, 0.0, 1.0, 1.0]], [[1, 0.5, 0.0, 0.25, 1.0]], [[null, 0.0, 0.0, 1.0, 1.0]], "
                             "[[1, 0.5, 0.0, 0.25, 1.0]], [], []]"));
}

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
    return fresco::testing::error_of([&] { sheet_from(fresco::to_json(value), "ann.json", small_study()); });
}

Value& first_answer(Value& value)
{
    return value.find("answers")->as_list().front();
}

}  // namespace

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
                      Contains("3.json and") && Contains("2.json are answers of the same participant, ann"));
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
        const study::Choice choice = i >= a + b ? study::Choice::neither : left ? study::Choice::left : study::Choice::right;
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

    // Two people contradict each other. In a quarter of the draws only the first counts, in a quarter only the second. Twenty
    // independent answers would have given [0.30, 0.70].
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
    const std::vector<AnswerSheet> sheets{
        {"1", true, {{0, 0, 2, study::Choice::left, 1}, {1, 2, 0, study::Choice::left, 1}}},
        {"2", true, {{0, 4, 5, study::Choice::neither, 1}, {0, 1, 3, study::Choice::right, 1}}}};
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
