#include "run/stage_choice.h"
#include "pipeline/pipeline_wiring.h"
#include <fresco/files_io.h>

#include <algorithm>

namespace fresco::host
{

StageKind kind_of(const PipelineStage& stage)
{
    return {program_name(stage), content_hash(to_json(*stage.options))};
}

const StageKind& Expectations::kind(const StageNode& node)
{
    const auto [known, is_new] = kinds_.try_emplace(&node);
    if (is_new)
        known->second = kind_of(*node.stage);
    return known->second;
}

std::optional<Usage> Expectations::measured(const StageNode& node)
{
    std::optional<Usage> usage = statistics_.last(kind(node));
    if (usage)
        usage->seconds *= 1 - node.done_share;
    return usage;
}

std::optional<double> Expectations::memory_mb(const StageNode& node)
{
    if (const auto usage = statistics_.last_with_options(kind(node)))
        return usage->memory_mb;
    // Runs with other options say how much a stage may need, but a stage that declares its memory needs no less than that.
    const auto others = statistics_.last(kind(node));
    const Value* declared = node.stage->type->declaration.find("memory_mb");
    const double declared_mb = declared != nullptr ? declared->as_double() : 0;
    if (!others && declared_mb <= 0)
        return std::nullopt;
    return std::max(declared_mb, others.value_or(Usage{}).memory_mb);
}

void Expectations::remember(const StageNode& node, Usage took)
{
    // A checkpoint saved the rest.
    took.seconds /= 1 - node.done_share;
    statistics_.add(kind(node), took);
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

bool Room::fits(std::optional<double> more_mb) const
{
    return idle || memory_mb <= 0 || (!is_closed && more_mb && taken_mb + *more_mb <= memory_mb);
}

void Room::take(int threads, std::optional<double> more_mb)
{
    cores -= threads;
    taken_mb += more_mb.value_or(0);
    idle = false;
    is_closed = is_closed || !more_mb;
}

std::vector<Start> choose_starts(RunState& state, const std::vector<bool>& may_begin, Expectations& expected, Room room)
{
    std::vector<Start> starts;
    int free = room.cores;
    for (const std::size_t place : state.ready())
    {
        if (room.cores <= 0)
            break;
        StageNode& node = state.nodes()[place];
        const std::optional<double> more_mb = expected.memory_mb(node);
        if (!may_begin[place])
            continue;
        if (!room.fits(more_mb))
        {
            // It needs an idle machine, which would never come if others went before it.
            if (!more_mb)
                break;
            continue;
        }
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
