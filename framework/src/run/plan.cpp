#include "run/plan.h"
#include "pipeline/pipeline_ports.h"
#include "run/estimate.h"
#include "run/exports.h"
#include "run/result_key.h"
#include "store/stage_record.h"
#include <fresco/file_access.h>

#include <algorithm>
#include <fmt/format.h>

namespace fresco::host
{
namespace
{

std::string running_producers(const StageNode& node, const RunState& state)
{
    std::string names;
    for (const std::size_t producer : node.producers)
        if (state.nodes()[producer].state == StageState::waiting)
            names += (names.empty() ? "" : ", ") + state.nodes()[producer].stage->name;
    return names;
}

std::string reason_to_run(const StageNode& node, const RunState& state, const Pipeline& pipeline, const Store& store)
{
    const std::string above = running_producers(node, state);
    if (!node.resolved)
        return "runs after " + above;
    if (!node.why_not.empty())
        return node.why_not;
    const auto record = read_stage_record(store, pipeline.file, node.stage->name);
    if (node.result)
        return "its result was removed from the store";
    if (!record)
        return "not stored yet";
    const std::string difference = explain_difference(record->key_document, node.key_document, *node.stage);
    return difference.empty() ? "its result was removed from the store" : difference;
}

std::string reason_to_rest(const StageNode& node)
{
    if (node.elsewhere && node.state == StageState::waiting)
        return "copied from the upstream store";
    switch (node.state)
    {
    case StageState::stored:
        return "stored";
    case StageState::not_needed:
        return "not needed: everything made from it is stored";
    case StageState::failed:
        return node.error;
    case StageState::blocked:
        return "something above it cannot run";
    default:
        return std::string(to_string(node.state));
    }
}

/// 0 where the store's list cannot be read: a run repairs it.
std::size_t files_to_copy(const StageNode& node, const Exporter& exporter)
{
    if (!node.exports_files || node.state != StageState::stored)
        return 0;
    try
    {
        return exporter.missing(*node.stage, node.result->object);
    }
    catch (const Error&)
    {
        return 0;
    }
}

}  // namespace

Plan make_plan(const Pipeline& pipeline, const std::filesystem::path& store_folder, const std::filesystem::path& out,
               const std::string& until, const std::map<std::string, CostFigures>& estimates,
               const std::filesystem::path& upstream_folder)
{
    set_input_roots(pipeline.inputs);
    const Store store(store_folder);
    const auto upstream = upstream_folder.empty() ? std::nullopt : std::optional<Store>(upstream_folder);
    const Statistics statistics(store);
    FileHashes hashes(store.file_index());
    RunState state(pipeline, store, hashes, until, upstream ? &*upstream : nullptr);
    state.update();
    const Exporter exporter(store, out, hashes);

    Plan plan;
    for (const auto& node : state.nodes())
    {
        if (!node.selected)
            continue;
        PlannedStage planned{
            node.stage->name, node.stage->type->type, node.state == StageState::waiting && !node.elsewhere, "", {}, false};
        planned.reason = planned.runs ? reason_to_run(node, state, pipeline, store) : reason_to_rest(node);
        if (planned.runs && node.done_share > 0)
            planned.reason = fmt::format("interrupted at {:.0f} %", 100 * node.done_share);
        else if (planned.runs && !node.begins_again.empty())
            planned.reason = "begins again: " + node.begins_again;
        planned.measured = statistics.knows(cost_name(*node.stage));
        planned.cost = statistics.corrected(cost_name(*node.stage), remaining_cost(node, estimates));
        if (planned.runs)
        {
            plan.total.seconds += planned.cost.seconds;
            plan.total.disk_mb += planned.cost.disk_mb;
            plan.total.memory_mb = std::max(plan.total.memory_mb, planned.cost.memory_mb);
        }
        planned.files_to_copy = files_to_copy(node, exporter);
        plan.stages.push_back(std::move(planned));
    }
    hashes.save();
    return plan;
}

}  // namespace fresco::host
