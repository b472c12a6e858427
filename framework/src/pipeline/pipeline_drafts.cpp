#include "pipeline/pipeline_drafts.h"
#include "base/machine.h"
#include "pipeline/pipeline_device.h"
#include "pipeline/pipeline_file_inputs.h"
#include "pipeline/pipeline_ports.h"

#include <algorithm>
#include <fmt/format.h>

namespace fresco::host
{
namespace
{

/// `input` without what is said of files.
std::string wired_text(const StageDraft& draft)
{
    const YamlNode::Entry* input = draft.config.find("input");
    if (!input || (draft.type && is_file_input(input->value, *draft.type.declaration)))
        return "";
    YamlNode node = input->value;
    if (draft.type)
        std::erase_if(node.entries,
                      [](const YamlNode::Entry& entry) { return entry.value.is_map() && entry.value.find("file"); });
    return node.identity();
}

}  // namespace

StageDrafts::StageDrafts(const PipelineDocument& document, const std::vector<MatrixAxis>& matrix, const Settings& settings,
                         TypeTable& types)
    : document_(document), matrix_(matrix), settings_(settings), types_(types)
{
    VarUse use(document.vars, matrix);
    std::map<unsigned long, Group> groups;
    for (std::size_t i = 0; i < document.stages.entries.size(); ++i)
    {
        const YamlNode::Entry& entry = document.stages.entries[i];
        std::set<std::string> vars = vars_named_in(entry.value);
        vars.merge(settings.vars_in(entry.key));
        axes_.push_back(use.use(vars));
        groups[axes_[i].to_ulong()].stages.push_back(i);
    }
    for (auto& [axes, vars] : use.unused())
        groups[axes].unused_vars = std::move(vars);
    for (auto& [axes, group] : groups)
    {
        group.axes = AxisSet(axes);
        groups_.push_back(std::move(group));
    }
}

Cell StageDrafts::cell(const Choices& choices)
{
    Cell cell{choices, std::vector<std::size_t>(axes_.size()), {}};
    for (Group& group : groups_)
    {
        const auto [batch, fresh] = group.batches.try_emplace(chosen_of(group.axes, choices));
        if (fresh)
            batch->second = make_batch(group, choices);
        cell.batches.push_back(batch->second);
        for (std::size_t i = 0; i < group.stages.size(); ++i)
            cell.stages[group.stages[i]] = first_stages_[batch->second] + i;
    }
    return cell;
}

std::size_t StageDrafts::make_batch(const Group& group, const Choices& choices)
{
    ProblemList problems;
    Variables variables(document_.vars, problems);
    for (std::size_t axis = 0; axis < matrix_.size(); ++axis)
        variables.choose(matrix_[axis].var, matrix_[axis].choices[choices[axis]].value);
    YamlNode written = document_.stages;
    written.entries.clear();
    for (const std::size_t stage : group.stages)
        written.entries.push_back(document_.stages.entries[stage]);
    YamlNode settled = variables.substitute(written);
    if (settled.is_map())
        for (YamlNode::Entry& entry : settled.entries)
            settings_.set_options(entry.key, entry.value, variables, types_, problems);
    variables.check_unused(group.unused_vars);
    first_stages_.push_back(stages_.size());
    OptionChecker checker(types_, problems);
    for (std::size_t i = 0; i < group.stages.size(); ++i)
        add_stage(group.stages[i], settled.is_map() ? std::move(settled.entries[i].value) : YamlNode(), checker, problems);
    problems_.push_back(problems.sorted());
    return first_stages_.size() - 1;
}

void StageDrafts::add_stage(std::size_t stage, YamlNode config, OptionChecker& checker, ProblemList& problems)
{
    const YamlNode::Entry& entry = document_.stages.entries[stage];
    StageDraft draft;
    draft.name = entry.key;
    draft.position = entry.position();
    draft.config = std::move(config);
    CheckedStage& checked = stages_.emplace_back();
    if (draft.config.is_map())
    {
        // What the stage lacks is reported at its name.
        draft.config.line = entry.line;
        draft.config.column = entry.column;
        draft.config.source = entry.source;
        const std::optional<std::string> type = type_named_by(draft.config, draft.title(), &problems);
        if (type)
            draft.type = types_.require(*type, "stage", draft.title(), draft.config.find("type")->value.position(), problems);
        if (draft.type)
            draft.options = checker.complete(draft.type, draft.config, {"type", "input"}, draft.title(), draft.uses);
        if (draft.type)
            settle_device(*draft.type.description, draft.options, machine_has_gpu);
        if (draft.type)
            settle_declared_ports(draft, types_, problems);
        FileInputs(types_, checker, problems).wire(draft);
    }
    const auto make_unique = [](auto& list, auto less)
    {
        std::sort(list.begin(), list.end(), less);
        list.erase(std::unique(list.begin(), list.end()), list.end());
    };
    checked.options = std::make_shared<const Value>(std::move(draft.options));
    checked.input_files = std::move(draft.uses.input_files);
    make_unique(checked.input_files, std::less<>());
    checked.components.assign(draft.uses.components.begin(), draft.uses.components.end());
    make_unique(checked.components, [](const TypeDescription* a, const TypeDescription* b) { return a->type < b->type; });
    checked.output_names = std::move(draft.uses.output_names);
    checked.files = draft.wires;
    checked.shape = shape_of(stage, std::move(draft));
}

std::size_t StageDrafts::shape_of(std::size_t stage, StageDraft draft)
{
    std::string identity = fmt::format("{} {} {} ", stage, fmt::ptr(draft.type.description), draft.files_failed);
    for (const Wire& wire : draft.wires)
        identity += wire.port + " ";
    for (const StageDraft::PartUse& use : draft.part_uses)
        identity += to_json(use.part) + " ";
    const auto [known, fresh] = known_shapes_.try_emplace(identity + wired_text(draft), shapes_.size());
    if (fresh)
    {
        draft.options = Value();
        draft.uses = {};
        std::erase_if(draft.config.entries, [](const YamlNode::Entry& entry) { return entry.key != "input"; });
        shapes_.push_back(std::move(draft));
    }
    return known->second;
}

}  // namespace fresco::host
