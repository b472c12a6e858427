#include "pipeline/pipeline_sweep.h"

#include <algorithm>

namespace fresco::host
{

void SweepMerger::add(std::vector<std::size_t> choices, std::vector<PipelineStage> stages,
                      const std::map<std::string, std::set<std::string>>& vars, const std::vector<Problem>& problems)
{
    for (const Problem& problem : problems)
    {
        const auto [known, fresh] = known_problems_.emplace(to_string(problem), problems_.size());
        if (fresh)
            problems_.push_back({problem, {}});
        problems_[known->second].second.push_back(cells_.size());
    }
    for (const auto& [stage, needed] : vars)
        for (std::size_t axis = 0; axis < axes_.size(); ++axis)
            if (needed.contains(axes_[axis].var))
                axes_of_[stage].insert(axis);
    cells_.push_back({std::move(choices), std::move(stages)});
}

void SweepMerger::report(ProblemList& problems) const
{
    for (const auto& [problem, cells] : problems_)
    {
        std::string common;
        for (std::size_t axis = 0; axis < axes_.size() && cells.size() < cells_.size(); ++axis)
        {
            const std::size_t choice = cells_[cells.front()].choices[axis];
            const bool same =
                std::all_of(cells.begin(), cells.end(), [&](std::size_t cell) { return cells_[cell].choices[axis] == choice; });
            if (same)
                common += (common.empty() ? " (with " : ", ") + axes_[axis].var + " '" + axes_[axis].choices[choice].label + "'";
        }
        problems.add(problem.position, problem.text + (common.empty() ? "" : common + ")"), problem.kind);
    }
}

/// What a stage reads depends on more axes than the stage itself: so does the stage then.
void SweepMerger::spread_axes()
{
    for (bool again = true; again;)
    {
        again = false;
        for (const Cell& cell : cells_)
            for (const PipelineStage& stage : cell.stages)
                for (const Wire& wire : stage.wires)
                    for (const std::size_t axis : axes_of_[wire.from_stage])
                        again = axes_of_[stage.name].insert(axis).second || again;
    }
}

std::string SweepMerger::label(const std::set<std::size_t>& axes, const Cell& cell) const
{
    std::string text;
    for (const std::size_t axis : axes)
        text += (text.empty() ? "" : ",") + axes_[axis].choices[cell.choices[axis]].label;
    return text;
}

void SweepMerger::merge_into(Pipeline& pipeline)
{
    spread_axes();
    std::set<std::size_t> all;
    for (std::size_t axis = 0; axis < axes_.size(); ++axis)
    {
        all.insert(axis);
        pipeline.sweep.axes.push_back(axes_[axis].var);
        pipeline.sweep.narrowed =
            pipeline.sweep.narrowed || std::any_of(axes_[axis].choices.begin(), axes_[axis].choices.end(),
                                                   [](const MatrixAxis::Choice& choice) { return !choice.chosen; });
    }
    std::map<std::string, std::size_t> places;
    for (Cell& cell : cells_)
    {
        Combination combination{label(all, cell), {}, {}};
        for (std::size_t axis = 0; axis < axes_.size(); ++axis)
            combination.values.push_back(axes_[axis].choices[cell.choices[axis]].label);
        const auto named = [&](const std::string& stage)
        {
            const std::string place = label(axes_of_[stage], cell);
            std::string name = stage;
            if (!place.empty())
                name.append("@").append(place);
            return name;
        };
        for (PipelineStage& stage : cell.stages)
        {
            stage.name = named(stage.own_name);
            const auto [place, fresh] = places.emplace(stage.name, pipeline.stages.size());
            combination.stages.push_back(place->second);
            if (!fresh)
                continue;
            stage.place = label(axes_of_[stage.own_name], cell);
            for (Wire& wire : stage.wires)
                if (!wire.from_stage.empty())
                    wire.from_stage = named(wire.from_stage);
            pipeline.stages.push_back(std::move(stage));
        }
        pipeline.sweep.combinations.push_back(std::move(combination));
    }
}

}  // namespace fresco::host
