#include "catch.h"
#include "results.h"

#include <limits>

using namespace study;
using fresco::Value;

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
