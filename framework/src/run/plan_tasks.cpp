#include "pipeline/pipeline_device.h"
#include "pipeline/pipeline_ports.h"
#include "run/estimate.h"
#include "run/run_state.h"
#include "run/task_table.h"
#include <fresco/error.h>
#include <fresco/file_access.h>

#include <optional>

namespace fresco::host
{
namespace
{

/// What `auto` devices stand for here, as `--set`: the machines that run the tasks may have others. Only where all stages of one
/// name have the same, so that a device that depends on an axis is not touched.
std::vector<std::pair<std::string, std::string>> settled_devices(const Pipeline& pipeline)
{
    std::map<std::string, std::optional<std::string>> devices;
    for (const PipelineStage& stage : pipeline.stages)
    {
        const std::string option = device_option(*stage.type);
        const Value* device = option.empty() ? nullptr : stage.options->find(option);
        const std::string set = device && device->is_string() ? option + "=" + device->as_string() : "";
        const auto [known, fresh] = devices.try_emplace(stage.own_name, set);
        if (!fresh && known->second != set)
            known->second.reset();
    }
    std::vector<std::pair<std::string, std::string>> sets;
    for (const auto& [stage, set] : devices)
        if (set && !set->empty())
            sets.emplace_back(stage + "." + set->substr(0, set->find('=')), set->substr(set->find('=') + 1));
    return sets;
}

}  // namespace

TaskTable plan_tasks(const PipelineRequest& request, const Pipeline& pipeline, const std::filesystem::path& store_folder,
                     const std::filesystem::path& out, const TaskSettings& settings)
{
    const Store store(store_folder);
    set_input_roots(pipeline.inputs);
    FileHashes hashes(store.file_index());
    RunState state(pipeline, store, hashes, request.until);
    state.update();
    hashes.save();
    std::map<std::string, CostFigures> estimates = estimate_pipeline(pipeline, settings.threads).stages;
    const Statistics statistics(store);
    std::vector<bool> runs;
    for (const StageNode& node : state.nodes())
    {
        if (node.state == StageState::failed)
            throw MissingInput("stage " + node.stage->name + ": " + node.error);
        runs.push_back(node.state == StageState::waiting);
        if (runs.back())
            estimates[node.stage->name] = statistics.corrected(cost_name(*node.stage), remaining_cost(node, estimates));
    }
    TaskTable table = make_task_table(pipeline, runs, estimates, settings);
    table.pipeline = {pipeline.file, pipeline.texts, request.sets, request.working_directory, request.until, request.preview};
    const auto devices = settled_devices(pipeline);
    table.pipeline.sets.insert(table.pipeline.sets.end(), devices.begin(), devices.end());
    for (const PipelineStage& stage : pipeline.stages)
    {
        table.plugins[stage.type->type] = {stage.type->library, stage.type->library_hash};
        for (const TypeDescription* component : stage.components)
            table.plugins[component->type] = {component->library, component->library_hash};
    }
    table.store = store_folder;
    table.out = out;
    return table;
}

}  // namespace fresco::host
