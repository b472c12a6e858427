#include "catch.h"
#include "figures.h"
#include "small_study.h"

using namespace study;

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
