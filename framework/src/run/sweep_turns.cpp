#include "run/sweep_turns.h"

#include <algorithm>

namespace fresco::host
{

SweepTurns::SweepTurns(const Sweep& sweep, int jobs, bool keep_going)
    : sweep_(sweep), jobs_(jobs), keep_going_(keep_going), begun_(sweep.combinations.size())
{
}

std::vector<bool> SweepTurns::take(const std::vector<StageNode>& stages)
{
    if (sweep_.combinations.empty())
        return std::vector<bool>(stages.size(), true);
    const auto any = [&](const Combination& combination, auto... states)
    {
        return std::any_of(combination.stages.begin(), combination.stages.end(),
                           [&](std::size_t stage) { return ((stages[stage].state == states) || ...); });
    };
    std::vector<bool> open(stages.size());
    int active = 0;
    bool failed = false;
    for (std::size_t i = 0; i < begun_.size(); ++i)
    {
        const Combination& combination = sweep_.combinations[i];
        active += begun_[i] && any(combination, StageState::waiting, StageState::running) ? 1 : 0;
        failed = failed || any(combination, StageState::failed);
    }
    for (std::size_t i = 0; i < begun_.size(); ++i)
    {
        const Combination& combination = sweep_.combinations[i];
        if (!begun_[i] && any(combination, StageState::waiting, StageState::running))
        {
            if (failed && !keep_going_)
                ended_early_ = true;
            else if (active < jobs_)
            {
                begun_[i] = true;
                ++active;
            }
        }
        if (begun_[i])
            for (const std::size_t stage : combination.stages)
                open[stage] = true;
    }
    return open;
}

}  // namespace fresco::host
