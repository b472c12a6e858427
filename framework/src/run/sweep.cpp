#include "run/sweep.h"
#include "base/unit_text.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>

namespace fresco::host
{
namespace
{

/// Characters on a terminal, not bytes.
std::size_t length(const std::string& text)
{
    return static_cast<std::size_t>(
        std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

std::string padded(const std::string& text, std::size_t width)
{
    return text + std::string(width - std::min(width, length(text)), ' ');
}

/// The outcome of each of the pipeline's stages; null where it was not selected.
std::vector<const StageOutcome*> by_stage(const Pipeline& pipeline, const RunSummary& summary)
{
    std::map<std::string, const StageOutcome*> named;
    for (const StageOutcome& outcome : summary.stages)
        named[outcome.stage] = &outcome;
    std::vector<const StageOutcome*> result;
    for (const PipelineStage& stage : pipeline.stages)
    {
        const auto found = named.find(stage.name);
        result.push_back(found == named.end() ? nullptr : found->second);
    }
    return result;
}

}  // namespace

std::vector<CombinationOutcome> combination_outcomes(const Pipeline& pipeline, const RunSummary& summary)
{
    const std::vector<const StageOutcome*> stages = by_stage(pipeline, summary);
    std::map<std::string, std::vector<std::size_t>> files;
    for (std::size_t i = 0; i < summary.files.size(); ++i)
        files[summary.files[i].stage].push_back(i);
    std::set<std::size_t> counted;
    std::vector<CombinationOutcome> result;
    for (const Combination& combination : pipeline.sweep.combinations)
    {
        CombinationOutcome outcome{&combination, "done", "", 0, 0, 0, {}};
        bool interrupted = false;
        bool left = false;
        for (const std::size_t number : combination.stages)
        {
            const StageOutcome* stage = stages[number];
            if (stage == nullptr)
                continue;
            if (counted.insert(number).second)
                outcome.seconds += stage->state == StageState::stored ? 0 : stage->seconds;
            outcome.ran_count += stage->state == StageState::done ? 1 : 0;
            outcome.stored_count += stage->state == StageState::stored ? 1 : 0;
            if (stage->state == StageState::failed && outcome.stage.empty())
                outcome.stage = stage->stage;
            interrupted = interrupted || stage->state == StageState::interrupted;
            left = left || stage->state == StageState::blocked;
            const auto& made = files[stage->stage];
            outcome.files.insert(outcome.files.end(), made.begin(), made.end());
        }
        if (!outcome.stage.empty())
            outcome.state = "failed";
        else if (interrupted)
            outcome.state = "interrupted";
        else if (left)
            outcome.state = "not run";
        result.push_back(std::move(outcome));
    }
    return result;
}

std::string sweep_table(const Sweep& sweep, const std::vector<CombinationOutcome>& outcomes)
{
    std::vector<std::size_t> widths;
    for (std::size_t axis = 0; axis < sweep.axes.size(); ++axis)
    {
        widths.push_back(length(sweep.axes[axis]));
        for (const CombinationOutcome& outcome : outcomes)
            widths.back() = std::max(widths.back(), length(outcome.combination->values[axis]));
    }
    std::string text;
    for (std::size_t axis = 0; axis < widths.size(); ++axis)
        text += padded(sweep.axes[axis], widths[axis]) + "  ";
    text += fmt::format("{:<11}  {:>10}  {:>5}  {:>6}  {:>5}\n", "", "time", "ran", "stored", "files");
    std::map<std::string, std::size_t> states;
    for (const CombinationOutcome& outcome : outcomes)
    {
        ++states[outcome.state];
        for (std::size_t axis = 0; axis < widths.size(); ++axis)
            text += padded(outcome.combination->values[axis], widths[axis]) + "  ";
        text += fmt::format("{:<11}  {:>10}  {:>5}  {:>6}  {:>5}", outcome.state,
                            outcome.seconds > 0 ? duration_text(outcome.seconds) : "", outcome.ran_count, outcome.stored_count,
                            outcome.files.size());
        text += (outcome.stage.empty() ? "" : "  at " + outcome.stage) + "\n";
    }
    std::string counts;
    for (const char* state : {"done", "failed", "interrupted", "not run"})
        if (states.contains(state))
            counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", states[state], state);
    return text + fmt::format("{} combination{}: {}\n", outcomes.size(), outcomes.size() == 1 ? "" : "s", counts);
}

}  // namespace fresco::host
