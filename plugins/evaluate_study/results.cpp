#include "results.h"

#include <fresco/evaluation/options.h>

#include <algorithm>
#include <fmt/format.h>

namespace study
{
namespace
{

using fresco::Value;

std::string percent_text(const Share& share)
{
    return fmt::format("{:.1f} % [{:.1f}, {:.1f}]", 100 * share.value, 100 * share.interval.low, 100 * share.interval.high);
}

Value share_value(const Share& share)
{
    Value value = fresco::evaluation::figure(share.value, share.interval);
    value.set("count", share.count);
    return value;
}

Value verdict_value(const Verdict& verdict)
{
    return Value::Map{{"first", verdict.first},
                      {"second", verdict.second},
                      {"participants", verdict.participants},
                      {"answers", verdict.answers},
                      {"first_share", share_value(verdict.shares[0])},
                      {"second_share", share_value(verdict.shares[1])},
                      {"neither_share", share_value(verdict.shares[2])},
                      {"preferred", verdict.preferred.empty() ? Value() : Value(verdict.preferred)}};
}

}  // namespace

std::string verdict_line(const Study& study, const Verdict& verdict)
{
    return fmt::format("{} {} {}, {} {}, neither {} of {} answers: {}", study.questions[verdict.question], verdict.first,
                       percent_text(verdict.shares[0]), verdict.second, percent_text(verdict.shares[1]),
                       percent_text(verdict.shares[2]), verdict.answers,
                       verdict.preferred.empty() ? "no significant preference" : verdict.preferred + " is chosen more often");
}

Value results_value(const Study& study, const std::vector<AnswerSheet>& sheets, const std::vector<Verdict>& verdicts)
{
    std::vector<double> seconds;
    for (const AnswerSheet& sheet : sheets)
        for (const Answer& answer : sheet.answers)
            seconds.push_back(answer.seconds);
    Value::List questions;
    for (std::size_t question = 0; question < study.questions.size(); ++question)
    {
        Value::List compared;
        for (const Verdict& verdict : verdicts)
            if (verdict.question == question)
                compared.push_back(verdict_value(verdict));
        questions.emplace_back(Value::Map{{"question", study.questions[question]}, {"comparisons", std::move(compared)}});
    }
    return Value::Map{{"study", study.id},
                      {"participants", sheets.size()},
                      {"complete", static_cast<std::size_t>(std::ranges::count(sheets, true, &AnswerSheet::complete))},
                      {"answers", seconds.size()},
                      {"mean_seconds", fresco::evaluation::number_or_null(fresco::evaluation::mean(seconds))},
                      {"questions", std::move(questions)}};
}

}  // namespace study
