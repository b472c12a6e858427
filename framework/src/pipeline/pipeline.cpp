#include "pipeline/pipeline.h"
#include "base/common.h"
#include "pipeline/graph.h"
#include "pipeline/pipeline_document.h"
#include "pipeline/pipeline_sets.h"
#include "pipeline/pipeline_sweep.h"
#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/wording.h>

#include <algorithm>
#include <fmt/format.h>
#include <ostream>
#include <set>

namespace fresco::host
{

namespace
{
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

/// The stages whose results nobody reads and that write no files, in a pipeline that has others that do.
ProblemList unread_stages(const Pipeline& pipeline)
{
    const auto is_sink = [](const PipelineStage& stage)
    {
        const Value::List& outputs = stage.type->declaration.at("outputs").as_list();
        const auto is_files = [](const Value& output) { return output.at("artifact").as_string() == Files::artifact_name; };
        return outputs.empty() || std::ranges::any_of(outputs, is_files);
    };
    std::set<std::string> read;
    for (const PipelineStage& stage : pipeline.stages)
        for (const Wire& wire : stage.wires)
            read.insert(wire.from_stage.substr(0, wire.from_stage.find('@')));
    const bool writes_files = std::ranges::any_of(pipeline.stages, is_sink);
    ProblemList warnings;
    for (const PipelineStage& stage : pipeline.stages)
        if (writes_files && !is_sink(stage) && !read.contains(stage.own_name))
            warnings.add(stage.position,
                         "no stage reads the result of '" + stage.own_name +
                             "': name it as the input of one, or leave it out (--without " + stage.own_name + ")",
                         ProblemKind::warning);
    return warnings;
}

void load(const PipelineRequest& request, const Catalog& catalog, PipelineResult& result, ProblemList& problems)
{
    PipelineDocument document = read_pipeline_document(result.pipeline.file, request.file.string(), request.texts, problems);
    result.pipeline.texts = document.texts;
    if (request.preview)
        apply_preview(document, request.file.string(), problems);
    Settings settings(request.sets, request.working_directory, problems);
    std::vector<MatrixAxis> matrix = read_matrix(document, problems);
    settings.set_vars(document, matrix);
    drop_stages(document, request.without, problems);
    if (!request.until.empty() && !document.stages.find(request.until))
        problems.add({"--until " + request.until, 0, 0},
                     "unknown stage '" + request.until + "'" + suggestion(request.until, document.stages.keys()));
    TypeTable types(catalog);
    ProblemList missing;
    load_stages(document, matrix, settings, types, result.pipeline, problems, request.keep_going ? &missing : nullptr);
    result.left_out = missing.sorted();
    if (request.until.empty())
        result.warnings = unread_stages(result.pipeline).sorted();
}
}  // namespace

const PipelineStage* Pipeline::find(std::string_view name) const
{
    const auto found = std::ranges::find(stages, name, &PipelineStage::name);
    return found == stages.end() ? nullptr : &*found;
}

int PipelineResult::exit_code() const
{
    for (const ProblemKind kind : {ProblemKind::invalid, ProblemKind::plugin, ProblemKind::missing_input})
        if (std::ranges::find(problems, kind, &Problem::kind) != problems.end())
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

std::string OutputOwners::blocked(const Owners::value_type& file, const Owners::value_type& below, const std::string& option)
{
    return "the stage " + file.second.stage + " would write the file " + file.first.generic_string() +
           " below --out, and the stage " + below.second.stage + " would write " + below.first.generic_string() +
           ": give one of them another " + option;
}

std::optional<std::string> OutputOwners::claim(const fs::path& path, const std::string& stage, bool is_file,
                                               const std::string& option)
{
    const auto own = owners_.emplace(path.lexically_normal(), Owner{stage, is_file}).first;
    const fs::path& name = own->first;
    if (own->second.stage != stage)
        return "the stages " + own->second.stage + " and " + stage + " would both write " + name.generic_string() +
               " below --out: give one of them another " + option;
    // Paths below a path sort after it.
    if (const auto next = std::next(own);
        is_file && next != owners_.end() && std::ranges::mismatch(name, next->first).in1 == name.end())
        return blocked(*own, *next, option);
    for (fs::path above = name.parent_path(); !above.empty(); above = above.parent_path())
        if (const auto file = owners_.find(above); file != owners_.end() && file->second.is_file)
            return blocked(*file, *own, option);
    return std::nullopt;
}

}  // namespace fresco::host
