#include "run/plan.h"
#include "base/common.h"
#include "base/glob.h"
#include "pipeline/pipeline_options.h"
#include "pipeline/pipeline_wiring.h"
#include "plugins/catalog.h"
#include "run/exports.h"
#include "run/result_key.h"
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

using Sizes = std::map<std::string, double>;

/// What the stages of a pipeline count by: fresco::Counted, by name, as their types declare it.
using Counts = std::map<std::string, const Value*>;

Counts counts_of(const Pipeline& pipeline)
{
    Counts counts;
    for (const PipelineStage& stage : pipeline.stages)
        if (const Value* cost = stage.type ? stage.type->declaration.find("cost") : nullptr)
            for (const auto& [name, counted] : cost->at("counts").as_map())
                counts.emplace(name, &counted);
    return counts;
}

class StageEstimator
{
  public:
    StageEstimator(const PipelineStage& stage, const Counts& counts, Sizes incoming, int cores, std::vector<std::string>& notes)
        : stage_(stage), counts_(counts), incoming_(std::move(incoming)), cores_(cores), notes_(notes)
    {
    }

    CostFigures run(Sizes& made)
    {
        const Value* cost = stage_.type ? stage_.type->declaration.find("cost") : nullptr;
        made = incoming_;
        if (cost == nullptr)
            return {};
        for (const auto& [name, size] : cost->at("makes").as_map())
        {
            const std::optional<double> count = counted(size, name);
            made.erase(name);
            if (count)
                made[name] = *count;
        }
        for (const auto& [name, counted] : counts_)
            if (const auto size = made.find(name); counted->at("carried_by").as_string().empty() || !incoming_.contains(name))
            {
                incoming_.erase(name);
                if (size != made.end())
                    incoming_[name] = size->second;
            }
        steps_ = cost->at("steps");
        const double share = cost->at("parallel_share").as_double();
        CostFigures figures;
        figures.seconds = total(cost->at("seconds"), incoming_, true) * (1 - share + share / cores_);
        figures.memory_mb = total(cost->at("memory_mb"), incoming_, false);
        figures.disk_mb = total(cost->at("disk_mb"), made, true);
        return figures;
    }

  private:
    /// Each once.
    void note(const std::string& text)
    {
        if (std::ranges::find(notes_, text) == notes_.end())
            notes_.push_back(text);
    }

    double number(const Value& option) const { return stage_.options->at(option.as_string()).as_double(); }

    /// The size, or what is assumed, which is noted.
    double known(const Sizes& sizes, const std::string& name)
    {
        if (const auto size = sizes.find(name); size != sizes.end())
            return size->second;
        const double assumed = counts_.at(name)->at("assumed").as_double();
        note(stage_.own_name + ": " + number_text(assumed) + " " + name + " assumed: no input says how many");
        return assumed;
    }

    double squares(const Value& option) const
    {
        double sum = 0;
        for (const Value& side : option.is_list() ? option.as_list() : Value::List{option})
            sum += side.as_double() * side.as_double();
        return sum;
    }

    double measured_files(const Value& size)
    {
        const std::string folder = stage_.options->at(size.at("files").as_string()).as_string();
        const GlobMeasure measure = measure_files(folder, size.at("pattern").as_string());
        if (measure.cut_short)
            note(stage_.name + ": '" + folder + "' holds more files than were counted");
        const double each = size.at("bytes_each").as_double();
        return each > 0 ? static_cast<double>(measure.bytes) / each : static_cast<double>(measure.files);
    }

    std::optional<double> base(const Value& size, const std::string& name)
    {
        if (const double number = size.at("number").as_double(); number > 0)
            return number;
        if (!size.at("option").as_string().empty())
            return number(size.at("option"));
        if (!size.at("files").as_string().empty())
            return measured_files(size);
        if (const Value& option = size.at("squares_of"); !option.as_string().empty())
        {
            // 0, or an empty list, stands for what the inputs have.
            const double sum = squares(stage_.options->at(option.as_string()));
            const auto brought = incoming_.find(name);
            return sum > 0                      ? std::optional(sum * counts_.at(name)->at("in_square").as_double())
                   : brought == incoming_.end() ? std::nullopt
                                                : std::optional(brought->second);
        }
        return incoming_[name] = known(incoming_, name);
    }

    std::optional<double> counted(const Value& size, const std::string& name)
    {
        std::optional<double> count = base(size, name);
        if (!count)
            return count;
        for (const Value& option : size.at("times").as_list())
            *count *= number(option);
        for (const Value& option : size.at("divided_by").as_list())
            if (const double divisor = number(option); divisor > 0)
                *count /= divisor;
        if (const Value& option = size.at("at_most"); !option.as_string().empty() && number(option) > 0)
            *count = std::min(*count, number(option));
        return count;
    }

    double steps() { return counted(steps_, steps_.at("brought").as_string()).value_or(0); }

    /// What one of `name` is counted for: each of another, or each step.
    double times(const std::string& name, const Sizes& sizes)
    {
        const std::string& each_of = counts_.at(name)->at("each_of").as_string();
        if (each_of.empty())
            return 1;
        return steps_.is_null() ? known(sizes, each_of) : steps();
    }

    double total(const Value& rates, const Sizes& sizes, bool of_each)
    {
        double sum = rates.at("fixed").as_double() + rates.at("per_core").as_double() * cores_;
        for (const auto& [name, rate] : rates.at("per").as_map())
            if (rate.as_double() > 0)
                sum += rate.as_double() * known(sizes, name) * (of_each ? times(name, sizes) : 1);
        if (const double rate = rates.at("per_step").as_double(); rate > 0)
            sum += rate * steps();
        return sum;
    }

    const PipelineStage& stage_;
    const Counts& counts_;
    Sizes incoming_;
    int cores_;
    std::vector<std::string>& notes_;
    Value steps_;
};

/// A wire of the artifact that is all about a size goes before others.
Sizes carried(const PipelineStage& stage, const Counts& counts, const std::map<std::string, Sizes>& made)
{
    Sizes others, own, last;
    for (const Wire& wire : stage.wires)
        if (const auto source = made.find(wire.from_stage); source != made.end())
        {
            const auto is_about = [&](const auto& count) { return count.second->at("carried_by").as_string() == wire.artifact; };
            const bool is_general = std::ranges::none_of(counts, is_about);
            for (const auto& [name, size] : source->second)
            {
                // Of a recording without a mesh, none is known.
                if (size <= 0)
                    continue;
                const auto& count = *counts.find(name);
                if (is_general || is_about(count))
                    (is_general ? others : own).emplace(name, size);
                if (count.second->at("also_carried_by").as_string() == wire.artifact)
                    last.emplace(name, size);
            }
        }
    own.merge(others);
    own.merge(last);
    return own;
}

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
    return attempt([&] { return exporter.missing(*node.stage, node.result->object); }).value_or(0);
}

}  // namespace

PipelineEstimate estimate_pipeline(const Pipeline& pipeline, int cores)
{
    PipelineEstimate result;
    const Counts counts = counts_of(pipeline);
    std::map<std::string, Sizes> made;
    for (const PipelineStage& stage : pipeline.stages)
        result.stages[stage.name] =
            StageEstimator(stage, counts, carried(stage, counts, made), std::max(cores, 1), result.notes).run(made[stage.name]);
    return result;
}

Plan make_plan(const Pipeline& pipeline, const std::filesystem::path& store_folder, const std::filesystem::path& out,
               const std::string& until, const std::map<std::string, CostFigures>& estimates,
               const std::filesystem::path& upstream_folder, bool replace)
{
    set_input_roots(pipeline.inputs);
    const Store store(store_folder);
    const auto upstream = upstream_folder.empty() ? std::nullopt : std::optional<Store>(upstream_folder);
    const Statistics statistics(store);
    FileHashes hashes(store.file_index());
    RunState state(pipeline, store, hashes, until, upstream ? &*upstream : nullptr);
    state.update();
    Exporter exporter(store, pipeline, out, hashes, replace);

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
        if (node.exports_files)
            std::ranges::move(exporter.obstacles(*node.stage, node.present ? node.result->object : ""),
                              std::back_inserter(plan.obstacles));
        plan.stages.push_back(std::move(planned));
    }
    hashes.save();
    return plan;
}

}  // namespace fresco::host
