#include "pipeline/pipeline.h"
#include "pipeline/output_owners.h"
#include "pipeline/pipeline_document.h"
#include "pipeline/pipeline_ports.h"
#include "pipeline/pipeline_sets.h"
#include "pipeline/pipeline_sweep.h"
#include "pipeline/pipeline_wiring.h"
#include <fresco/error.h>
#include <fresco/wording.h>

#include <algorithm>
#include <map>
#include <set>

namespace fresco::host
{
namespace
{
/// The stages with everything substituted and set.
YamlNode settled_stages(const PipelineDocument& document, const Settings& settings, TypeTable& types, ProblemList& problems)
{
    Variables variables(document.vars, problems);
    YamlNode stages = variables.substitute(document.stages);
    if (stages.is_map())
        settings.set_options(stages, variables, types, problems);
    variables.check_unused();
    return stages.is_map() ? stages : YamlNode{};
}

std::vector<StageDraft> draft_stages(const YamlNode& stages, TypeTable& types, OptionChecker& checker, ProblemList& problems)
{
    std::vector<StageDraft> drafts;
    for (const YamlNode::Entry& entry : stages.entries)
    {
        StageDraft& draft = drafts.emplace_back();
        draft.name = entry.key;
        draft.position = entry.position();
        draft.config = entry.value;
        if (!draft.config.is_map())
            continue;
        // What the stage lacks is reported at its name.
        draft.config.line = entry.line;
        draft.config.column = entry.column;
        draft.config.source = entry.source;
        const std::optional<std::string> type = type_named_by(draft.config, draft.title(), &problems);
        if (type)
            draft.type = types.require(*type, "stage", draft.title(), draft.config.find("type")->value.position(), problems);
        if (draft.type)
            draft.options = checker.complete(draft.type, draft.config, {"type", "input"}, draft.title(), draft.uses);
        if (draft.type)
            settle_declared_ports(draft, types, problems);
    }
    return drafts;
}

void check_output_names(const std::vector<StageDraft>& drafts, ProblemList& problems)
{
    OutputOwners owners;
    for (const StageDraft& draft : drafts)
        for (const OptionUses::OutputUse& use : draft.uses.output_names)
            if (const auto collision = owners.claim(use.path, draft.name, use.option))
                problems.add(use.position, *collision);
}

void check_until(const std::string& until, const YamlNode& stages, ProblemList& problems)
{
    if (until.empty() || !stages.is_map() || stages.find(until))
        return;
    std::vector<std::string> names;
    for (const YamlNode::Entry& entry : stages.entries)
        names.push_back(entry.key);
    problems.add({"--until " + until, 0, 0}, "unknown stage '" + until + "'" + suggestion(until, names));
}

PipelineStage finished(StageDraft&& draft)
{
    PipelineStage stage;
    stage.name = std::move(draft.name);
    stage.own_name = stage.name;
    stage.type = draft.type.description;
    stage.own_type = std::move(draft.own_type);
    stage.options = std::move(draft.options);
    stage.wires = std::move(draft.wires);
    stage.input_files = std::move(draft.uses.input_files);
    std::sort(stage.input_files.begin(), stage.input_files.end());
    stage.input_files.erase(std::unique(stage.input_files.begin(), stage.input_files.end()), stage.input_files.end());
    stage.components.assign(draft.uses.components.begin(), draft.uses.components.end());
    std::sort(stage.components.begin(), stage.components.end(),
              [](const TypeDescription* a, const TypeDescription* b) { return a->type < b->type; });
    stage.position = std::move(draft.position);
    return stage;
}

/// Reports what is wrong, or returns the stages in their order.
std::vector<PipelineStage> load_stages(const PipelineDocument& document, const Settings& settings, TypeTable& types,
                                       ProblemList& problems)
{
    OptionChecker checker(types, problems);
    const YamlNode stages = settled_stages(document, settings, types, problems);
    std::vector<StageDraft> drafts = draft_stages(stages, types, checker, problems);
    Wiring(drafts, types, checker, problems).wire_all();
    const StageGraph graph = check_graph(drafts, problems);
    check_output_names(drafts, problems);
    std::vector<PipelineStage> result;
    if (problems.empty())
        for (const std::size_t index : graph.order())
            result.push_back(finished(std::move(drafts[index])));
    return result;
}

/// Loads the stages once for each combination of the axes' values.
void load_sweep(const PipelineDocument& document, const std::vector<MatrixAxis>& axes, const Settings& settings, TypeTable& types,
                Pipeline& pipeline, ProblemList& problems)
{
    std::vector<std::vector<std::size_t>> cells;
    try
    {
        cells = combinations(axes);
    }
    catch (const Error& error)
    {
        problems.add(document.matrix.entries.front().position(), error.what());
        return;
    }
    SweepMerger merger(axes);
    for (const auto& choices : cells)
    {
        PipelineDocument one = document;
        for (std::size_t axis = 0; axis < axes.size(); ++axis)
            one.vars.find(axes[axis].var)->value = axes[axis].choices[choices[axis]].value;
        ProblemList own;
        std::vector<PipelineStage> stages = load_stages(one, settings, types, own);
        std::map<std::string, std::set<std::string>> vars;
        const Variables variables(one.vars, own);
        for (const PipelineStage& stage : stages)
        {
            vars[stage.name] = variables.needed_by(document.stages.find(stage.name)->value);
            vars[stage.name].merge(settings.vars_in(stage.name, variables));
        }
        merger.add(choices, std::move(stages), vars, own.sorted());
    }
    merger.report(problems);
    if (problems.empty())
        merger.merge_into(pipeline);
}

StageGraph graph_of(const std::vector<PipelineStage>& stages)
{
    StageGraph graph(stages.size());
    std::map<std::string_view, std::size_t> places;
    for (std::size_t i = 0; i < stages.size(); ++i)
    {
        places[stages[i].name] = i;
        for (const Wire& wire : stages[i].wires)
            if (!wire.from_stage.empty())
                graph.add_edge(places.at(wire.from_stage), i);
    }
    return graph;
}

/// Where the folders under `inputs` are. What their vars lack is reported where they are used.
std::map<std::string, std::filesystem::path> read_inputs(const PipelineDocument& document, ProblemList& problems)
{
    std::map<std::string, std::filesystem::path> inputs;
    ProblemList of_vars;
    Variables variables(document.vars, of_vars);
    for (const std::string& name : document.inputs)
    {
        const YamlNode value = variables.substitute(document.vars.find(name)->value);
        const bool is_path = value.is_scalar() && !value.text.empty();
        if (document.matrix.find(name) || (value.is_valid() && !value.is_null() && !is_path))
            problems.add(value.position(), "the input '" + name + "' must be the path of one folder, got " +
                                               (document.matrix.find(name) ? "the values of an axis" : value.summary()));
        else if (is_path)
        {
            const std::filesystem::path folder = (value.path_base() / value.text).lexically_normal();
            inputs[name] = folder.has_filename() ? folder : folder.parent_path();
        }
    }
    return inputs;
}

void load(const PipelineRequest& request, const Catalog& catalog, PipelineResult& result, ProblemList& problems)
{
    PipelineDocument document = read_pipeline_document(result.pipeline.file, request.file.string(), problems);
    result.pipeline.texts = document.texts;
    Settings settings(request.sets, request.working_directory, problems);
    std::vector<MatrixAxis> axes = read_matrix(document, problems);
    settings.set_vars(document, axes);
    check_until(request.until, document.stages, problems);
    result.pipeline.inputs = read_inputs(document, problems);
    TypeTable types(catalog);
    if (!axes.empty())
        return load_sweep(document, axes, settings, types, result.pipeline, problems);
    std::vector<PipelineStage> stages = load_stages(document, settings, types, problems);
    if (problems.empty())
        result.pipeline.stages = std::move(stages);
}
}  // namespace

const PipelineStage* Pipeline::find(std::string_view name) const
{
    const auto found = std::find_if(stages.begin(), stages.end(), [&](const PipelineStage& stage) { return stage.name == name; });
    return found == stages.end() ? nullptr : &*found;
}

int PipelineResult::exit_code() const
{
    for (const ProblemKind kind : {ProblemKind::invalid, ProblemKind::plugin, ProblemKind::missing_input})
        if (std::any_of(problems.begin(), problems.end(), [&](const Problem& problem) { return problem.kind == kind; }))
            return static_cast<int>(kind);
    return 0;
}

PipelineResult load_pipeline(const PipelineRequest& request, const Catalog& catalog)
{
    PipelineRequest absolute = request;
    if (absolute.working_directory.is_relative())
        absolute.working_directory = (std::filesystem::current_path() / absolute.working_directory).lexically_normal();
    PipelineResult result;
    result.pipeline.file = (absolute.working_directory / request.file).lexically_normal();
    ProblemList problems;
    try
    {
        load(absolute, catalog, result, problems);
    }
    catch (const MissingInput& error)
    {
        problems.add({request.file.string(), 0, 0}, error.what(), ProblemKind::missing_input);
    }
    catch (const Error& error)
    {
        problems.add({request.file.string(), 0, 0}, error.what());
    }
    result.problems = problems.sorted();
    if (!result.problems.empty())
    {
        result.pipeline.stages.clear();
        result.pipeline.sweep = {};
    }
    result.pipeline.graph = std::make_shared<const StageGraph>(graph_of(result.pipeline.stages));
    return result;
}

}  // namespace fresco::host
