#include "run/stage_choice.h"
#include "pipeline/pipeline_wiring.h"

#include <algorithm>

namespace fresco::host
{

const CostFigures& StageCosts::expected(const StageNode& node)
{
    const auto [answer, is_new] = answers_.try_emplace(&node);
    if (is_new || answer->second.key != node.key)
        answer->second = {node.key, statistics_.corrected(cost_name(*node.stage), remaining_cost(node, estimates_))};
    return answer->second.cost;
}

void StageCosts::remember(const StageNode& node, const CostFigures& measured) const
{
    record_cost(store_, cost_name(*node.stage), measured, remaining_cost(node, estimates_));
}

SweepTurns::SweepTurns(const Sweep& sweep, int jobs, bool keep_going)
    : sweep_(sweep), jobs_(jobs), keep_going_(keep_going), begun_(sweep.combinations.size())
{
}

std::vector<bool> SweepTurns::take(const std::vector<StageNode>& stages)
{
    if (sweep_.combinations.empty())
        return std::vector<bool>(stages.size(), true);
    const auto any = [&](const Combination& combination, auto... states) {
        return std::ranges::any_of(combination.stages,
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

void Room::take(int threads, double more_mb)
{
    cores -= threads;
    taken_mb += more_mb;
    idle = false;
}

std::vector<Start> choose_starts(RunState& state, const std::vector<bool>& may_begin, StageCosts& costs, Room room)
{
    std::vector<Start> starts;
    int free = room.cores;
    for (const std::size_t place : state.ready())
    {
        if (room.cores <= 0)
            break;
        StageNode& node = state.nodes()[place];
        const double more_mb = costs.expected(node).memory_mb;
        const bool fits = room.idle || room.memory_mb <= 0 || room.taken_mb + more_mb <= room.memory_mb;
        if (!may_begin[place] || !fits)
            continue;
        room.take(1, more_mb);
        starts.push_back({&node});
    }
    int left = static_cast<int>(starts.size());
    for (Start& start : starts)
    {
        start.threads = std::max(1, free / left);
        free -= start.threads;
        --left;
    }
    return starts;
}

}  // namespace fresco::host
