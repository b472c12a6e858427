#include "run/plan.h"
#include "base/common.h"
#include "pipeline/pipeline_options.h"
#include "run/exports.h"
#include "run/result_key.h"
#include "run/stage_choice.h"
#include "store/stage_record.h"
#include <fresco/error.h>
#include <fresco/file_access.h>

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <set>
#include <utility>

namespace fresco::host
{

namespace
{

std::string reason_to_run(const StageNode& node, const RunState& state, const Pipeline& pipeline, const Store& store)
{
    if (!node.resolved)
    {
        std::string above;
        for (const std::size_t producer : node.producers)
            if (state.nodes()[producer].state == StageState::waiting)
                above += (above.empty() ? "" : ", ") + state.nodes()[producer].stage->name;
        return "runs after " + above;
    }
    if (!node.why_not.empty())
        return node.why_not;
    const auto record = read_stage_record(store, pipeline.file, node.stage->name);
    if (!node.result && !record)
        return "not stored yet";
    const std::string difference = node.result ? "" : explain_difference(record->key_document, node.key_document, *node.stage);
    return difference.empty() ? "its result was removed from the store" : difference;
}

std::string reason_to_rest(const StageNode& node)
{
    switch (node.state)
    {
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
    return attempt([&] { return exporter.missing(*node.stage, node.result->object).size(); }).value_or(0);
}

}  // namespace

Plan make_plan(const Pipeline& pipeline, const std::filesystem::path& store_folder, const std::filesystem::path& out,
               const std::string& until, bool replace)
{
    const Store store(store_folder);
    Expectations expected(store);
    FileHashes hashes(store.file_index());
    RunState state(pipeline, store, hashes, until);
    state.update();
    Exporter exporter(store, pipeline, out, hashes, replace);

    Plan plan;
    for (const auto& node : state.nodes())
    {
        if (!node.selected)
            continue;
        PlannedStage planned{
            .stage = node.stage->name, .type = node.stage->type->type, .runs = node.state == StageState::waiting};
        planned.reason = planned.runs ? reason_to_run(node, state, pipeline, store) : reason_to_rest(node);
        if (planned.runs && node.done_share > 0)
            planned.reason = fmt::format("interrupted at {:.0f} %", 100 * node.done_share);
        else if (planned.runs && !node.begins_again.empty())
            planned.reason = "begins again: " + node.begins_again;
        planned.chosen = types_by_marks(*node.stage);
        planned.measured = expected.measured(node);
        if (planned.runs && planned.measured)
        {
            plan.total.seconds += planned.measured->seconds;
            plan.total.memory_mb = std::max(plan.total.memory_mb, planned.measured->memory_mb);
        }
        plan.unmeasured_count += planned.runs && !planned.measured ? 1 : 0;
        planned.files_to_copy = files_to_copy(node, exporter);
        if (node.exports_files)
            std::ranges::move(exporter.obstacles(*node.stage, node.present ? node.result->object : ""),
                              std::back_inserter(plan.obstacles));
        plan.stages.push_back(std::move(planned));
    }
    hashes.save();
    return plan;
}

}  // namespace fresco::host
