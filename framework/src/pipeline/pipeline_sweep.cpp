#include "pipeline/pipeline_sweep.h"
#include "pipeline/output_owners.h"

#include <algorithm>

namespace fresco::host
{
namespace
{
/// Stages that make parts for which others have rules: they run early, since only then is it known whether the rules fit.
std::vector<std::size_t> makers_of_ruled_parts(const std::vector<StageDraft>& stages)
{
    std::vector<std::size_t> makers;
    for (const StageDraft& stage : stages)
        for (const StageDraft::PartUse& use : stage.part_uses)
            if (const auto wire = std::ranges::find(stage.wires, use.port, &Wire::port); wire != stage.wires.end())
                if (const auto maker = std::ranges::find(stages, wire->from_stage, &StageDraft::name); maker != stages.end())
                    makers.push_back(static_cast<std::size_t>(maker - stages.begin()));
    return makers;
}
}  // namespace

void SweepBuilder::add(const Choices& choices)
{
    Cell cell = drafts_.cell(choices);
    const Structure& structure = structure_of(cell);
    const std::vector<Problem> collisions = colliding_outputs(cell);
    members_.push_back({std::move(cell), &structure});
    for (const std::size_t batch : members_.back().cell.batches)
        note(drafts_.problems(batch));
    note(structure.problems);
    note(collisions);
}

/// Of the combination that was added last.
void SweepBuilder::note(const std::vector<Problem>& problems)
{
    const std::size_t member = members_.size() - 1;
    for (const Problem& problem : problems)
    {
        const auto [known, fresh] = known_problems_.emplace(to_string(problem), problems_.size());
        if (fresh)
            problems_.push_back({problem, {}});
        std::vector<std::size_t>& members = problems_[known->second].second;
        if (members.empty() || members.back() != member)
            members.push_back(member);
    }
}

const SweepBuilder::Structure& SweepBuilder::structure_of(const Cell& cell)
{
    std::vector<std::size_t> shapes;
    for (const std::size_t stage : cell.stages)
        shapes.push_back(drafts_.stage(stage).shape);
    const auto [known, fresh] = structures_.try_emplace(shapes);
    Structure& structure = known->second;
    if (!fresh)
        return structure;
    std::vector<StageDraft> stages;
    for (const std::size_t shape : shapes)
        stages.push_back(drafts_.shape(shape));
    ProblemList problems;
    Wiring(stages, problems).wire_all();
    structure.order = check_graph(stages, problems).order(makers_of_ruled_parts(stages));
    structure.problems = problems.sorted();
    for (StageDraft& stage : stages)
    {
        std::erase_if(stage.wires, [](const Wire& wire) { return wire.from_stage.empty(); });
        structure.wires.push_back(std::move(stage.wires));
    }
    return structure;
}

std::vector<Problem> SweepBuilder::colliding_outputs(const Cell& cell) const
{
    ProblemList problems;
    OutputOwners owners;
    for (std::size_t i = 0; i < cell.stages.size(); ++i)
        for (const OptionUses::OutputUse& use : drafts_.stage(cell.stages[i]).output_names)
            if (const auto collision = owners.claim(use.path, document_.stages.entries[i].key, use.is_file, use.option))
                problems.add(use.position, *collision);
    return problems.sorted();
}

void SweepBuilder::report(ProblemList& problems) const
{
    for (const auto& [problem, members] : problems_)
    {
        std::string common;
        for (std::size_t axis = 0; axis < matrix_.size() && members.size() < members_.size(); ++axis)
        {
            const std::size_t choice = members_[members.front()].cell.choices[axis];
            const bool same = std::all_of(members.begin(), members.end(),
                                          [&](std::size_t member) { return members_[member].cell.choices[axis] == choice; });
            if (same)
                common +=
                    (common.empty() ? " (with " : ", ") + matrix_[axis].var + " '" + matrix_[axis].choices[choice].label + "'";
        }
        problems.add(problem.position, problem.text + (common.empty() ? "" : common + ")"), problem.kind);
    }
}

/// What a stage reads depends on more axes than the stage itself: so does the stage then.
std::vector<AxisSet> SweepBuilder::spread_axes(const std::map<std::string, AxisSet>& more) const
{
    std::vector<AxisSet> axes;
    for (std::size_t i = 0; i < document_.stages.entries.size(); ++i)
    {
        const auto found = more.find(document_.stages.entries[i].key);
        axes.push_back(drafts_.axes_of(i) | (found == more.end() ? AxisSet() : found->second));
    }
    for (bool again = true; again;)
    {
        again = false;
        for (const auto& [shapes, structure] : structures_)
            for (const std::size_t stage : structure.order)
                for (const Wire& wire : structure.wires[stage])
                {
                    const AxisSet before = axes[stage];
                    axes[stage] |= axes[numbers_.at(wire.from_stage)];
                    again = again || axes[stage] != before;
                }
    }
    return axes;
}

std::string SweepBuilder::name_of(std::size_t stage, const Choices& choices, const std::vector<AxisSet>& axes) const
{
    std::string name = document_.stages.entries[stage].key;
    if (axes[stage].any())
        name.append("@").append(label_of(axes[stage], choices, matrix_));
    return name;
}

PipelineStage SweepBuilder::stage_of(const Member& member, std::size_t number, const std::vector<AxisSet>& axes) const
{
    const CheckedStage& checked = drafts_.stage(member.cell.stages[number]);
    const StageDraft& shape = drafts_.shape(checked.shape);
    PipelineStage stage;
    stage.name = name_of(number, member.cell.choices, axes);
    stage.own_name = shape.name;
    stage.place = label_of(axes[number], member.cell.choices, matrix_);
    stage.type = shape.type.description;
    stage.own_type = shape.own_type;
    stage.options = checked.options;
    stage.wires = member.structure->wires[number];
    for (Wire& wire : stage.wires)
        wire.from_stage = name_of(numbers_.at(wire.from_stage), member.cell.choices, axes);
    stage.wires.insert(stage.wires.end(), checked.files.begin(), checked.files.end());
    const TypeDeclaration& type = *shape.type.declaration;
    const auto place = [&](const Wire& wire) { return type.input(wire.port) - type.inputs.data(); };
    std::sort(stage.wires.begin(), stage.wires.end(), [&](const Wire& a, const Wire& b) { return place(a) < place(b); });
    stage.input_files = checked.input_files;
    stage.components = checked.components;
    stage.position = shape.position;
    return stage;
}

void SweepBuilder::build(Pipeline& pipeline, const std::map<std::string, AxisSet>& more_axes)
{
    for (std::size_t i = 0; i < document_.stages.entries.size(); ++i)
        numbers_[document_.stages.entries[i].key] = i;
    const std::vector<AxisSet> axes = spread_axes(more_axes);
    const AxisSet all = AxisSet().set();
    for (std::size_t i = 0; i < document_.stages.entries.size() && !matrix_.empty(); ++i)
        for (std::size_t axis = 0; axis < matrix_.size(); ++axis)
            if (axes[i][axis])
                pipeline.sweep.stage_axes[document_.stages.entries[i].key].push_back(matrix_[axis].var);
    std::vector<std::map<Choices, std::size_t>> places(axes.size());
    for (const Member& member : members_)
    {
        Combination combination{label_of(all, member.cell.choices, matrix_), {}, {}};
        for (std::size_t axis = 0; axis < matrix_.size(); ++axis)
            combination.values.push_back(matrix_[axis].choices[member.cell.choices[axis]].label);
        for (const std::size_t stage : member.structure->order)
        {
            const auto [place, fresh] =
                places[stage].try_emplace(chosen_of(axes[stage], member.cell.choices), pipeline.stages.size());
            combination.stages.push_back(place->second);
            if (fresh)
                pipeline.stages.push_back(stage_of(member, stage, axes));
        }
        if (!matrix_.empty())
            pipeline.sweep.combinations.push_back(std::move(combination));
    }
}

}  // namespace fresco::host
