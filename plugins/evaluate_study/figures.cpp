#include "figures.h"

#include <algorithm>
#include <limits>

namespace study
{
namespace
{

using fresco::evaluation::Interval;

constexpr std::size_t neither = 2;

/// Of one participant: how often the first method, the second, and neither was chosen.
using Counts = std::array<std::int64_t, 3>;

std::int64_t sum(const Counts& counts)
{
    return counts[0] + counts[1] + counts[2];
}

std::size_t chosen(const Answer& answer, const Study& study, const std::string& first)
{
    if (answer.choice == Choice::neither)
        return neither;
    const std::size_t picture = answer.choice == Choice::left ? answer.left : answer.right;
    return study.pictures[picture].method == first ? 0 : 1;
}

bool is_about(const Answer& answer, const Study& study, const Comparison& comparison)
{
    const std::string& left = study.pictures[answer.left].method;
    const std::string& right = study.pictures[answer.right].method;
    return std::minmax(left, right) == std::minmax(comparison.first, comparison.second);
}

/// Of the participants that answered.
std::vector<Counts> counted(const Study& study, const std::vector<AnswerSheet>& sheets, std::size_t question,
                            const Comparison& comparison)
{
    std::vector<Counts> result;
    for (const AnswerSheet& sheet : sheets)
    {
        Counts counts{};
        for (const Answer& answer : sheet.answers)
            if (answer.question == question && is_about(answer, study, comparison))
                ++counts[chosen(answer, study, comparison.first)];
        if (sum(counts) > 0)
            result.push_back(counts);
    }
    return result;
}

Share share_of(const std::vector<Counts>& participants, std::size_t which, const fresco::evaluation::Bootstrap& bootstrap)
{
    const auto value_of = [&](std::span<const std::size_t> drawn)
    {
        std::int64_t count = 0;
        std::int64_t all = 0;
        for (const std::size_t i : drawn)
        {
            count += participants[i][which];
            all += sum(participants[i]);
        }
        return static_cast<double>(count) / static_cast<double>(all);
    };
    Share share;
    std::int64_t all = 0;
    for (const Counts& counts : participants)
    {
        share.count += counts[which];
        all += sum(counts);
    }
    share.value = static_cast<double>(share.count) / static_cast<double>(all);
    share.interval = fresco::evaluation::wilson_interval(share.count, all);
    if (participants.size() >= 2)
    {
        const Interval drawn = fresco::evaluation::bootstrap_interval(participants.size(), value_of, bootstrap);
        share.interval = {std::min(share.interval.low, drawn.low), std::max(share.interval.high, drawn.high)};
    }
    return share;
}

}  // namespace

std::vector<Verdict> verdicts(const Study& study, const std::vector<AnswerSheet>& sheets,
                              const fresco::evaluation::Bootstrap& bootstrap)
{
    std::vector<Verdict> result;
    const auto compared = comparisons(study);
    for (std::size_t question = 0; question < study.questions.size(); ++question)
        for (const Comparison& comparison : compared)
        {
            const auto participants = counted(study, sheets, question, comparison);
            if (participants.empty())
                continue;
            Verdict verdict{question, comparison.first, comparison.second, participants.size(), 0, {}, {}};
            for (std::size_t which = 0; which < verdict.shares.size(); ++which)
            {
                verdict.shares[which] = share_of(participants, which, bootstrap);
                verdict.answers += verdict.shares[which].count;
            }
            const Interval& first = verdict.shares[0].interval;
            const Interval& second = verdict.shares[1].interval;
            if (participants.size() >= 2 && first.low > second.high)
                verdict.preferred = verdict.first;
            if (participants.size() >= 2 && second.low > first.high)
                verdict.preferred = verdict.second;
            result.push_back(std::move(verdict));
        }
    return result;
}

}  // namespace study
