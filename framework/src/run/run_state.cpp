#include "run/run_state.h"
#include "base/common.h"
#include "base/machine.h"
#include "base/process.h"
#include "pipeline/graph.h"
#include "pipeline/pipeline_options.h"
#include "run/exports.h"
#include "run/result_key.h"
#include <fresco/error.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace fresco::host
{

std::string_view to_string(StageState state)
{
    constexpr std::array<std::string_view, 9> names{"not selected", "not needed", "stored",  "waiting",    "running",
                                                    "ran",          "failed",     "not run", "interrupted"};
    return names.at(static_cast<std::size_t>(state));
}

std::vector<bool> with_needed(const Pipeline& pipeline, std::vector<bool> stages)
{
    // Stages are in a topological order: whoever needs a stage comes after it.
    for (std::size_t i = stages.size(); i-- > 0;)
        if (stages[i])
            for (const std::size_t producer : pipeline.graph->needs(i))
                stages[producer] = true;
    return stages;
}

namespace
{

void look_at_checkpoint(StageNode& node, const Store& store)
{
    node.done_share = store.checkpoint_share(node.key);
    node.begins_again.clear();
    if (node.done_share == 0)
        return;
    try
    {
        node.begins_again = store.checkpoint_refusal(node.key, computing_place(works_on_gpu(*node.stage)));
    }
    catch (const Error& error)
    {
        node.begins_again = std::string("the checkpoint cannot be used: ") + error.what();
    }
    if (!node.begins_again.empty())
        node.done_share = 0;
}

}  // namespace

RunState::RunState(const Pipeline& pipeline, const Store& store, FileHashes& hashes, const std::string& until,
                   const RunPart* part)
    : store_(store), hashes_(hashes), part_(part)
{
    std::vector<bool> wanted;  // First the ends.
    for (const auto& stage : pipeline.stages)
    {
        const std::size_t place = nodes_.size();
        StageNode& node = nodes_.emplace_back();
        node.stage = &stage;
        node.producers = pipeline.graph->needs(place);
        node.consumers = pipeline.graph->needed_by(place);
        node.may_run = part == nullptr || part->stages.contains(stage.name);
        node.exports_files = node.may_run && !files_outputs(stage).empty();
        wanted.push_back(part != nullptr ? node.may_run : until.empty() || stage.own_name == until);
    }
    if (part == nullptr && !until.empty() && std::ranges::find(wanted, true) == wanted.end())
        throw Error("--until " + until + ": the pipeline has no stage of this name");
    wanted = with_needed(pipeline, std::move(wanted));
    for (std::size_t place = 0; place < nodes_.size(); ++place)
        nodes_[place].selected = wanted[place];
}

void RunState::resolve(StageNode& node)
{
    if (std::ranges::any_of(node.producers, [&](std::size_t producer) { return !nodes_[producer].result; }))
    {
        node.resolved = false;
        node.result.reset();
        node.present = false;
        return;
    }
    std::map<std::string, std::string> upstream;
    for (const std::size_t producer : node.producers)
        upstream[nodes_[producer].stage->name] = nodes_[producer].result->object;
    if (!node.resolved || node.upstream != upstream)
    {
        node.key_document = key_document(*node.stage, upstream, hashes_);
        node.key = key_of(node.key_document);
        look_at_checkpoint(node, store_);
        node.upstream = std::move(upstream);
        node.resolved = true;
        node.why_not.clear();
        node.result = store_.lookup(node.key, &node.why_not, node.stage->input_files);
    }
    node.present = node.result && store_.present(*node.result);
}

void RunState::set_state(StageNode& node)
{
    if (!node.selected)
        node.state = StageState::not_selected;
    const bool fixed = node.state == StageState::running || node.state == StageState::failed ||
                       node.state == StageState::interrupted || !node.selected;
    if (fixed)
        return;
    try
    {
        resolve(node);
    }
    catch (const MissingInput& error)
    {
        node.error = error.what();
        node.error_code = worker_missing_input;
    }
    if (!node.error.empty())
    {
        node.state = StageState::failed;
        return;
    }
    const bool broken = std::ranges::any_of(node.producers, [&](std::size_t producer) { return views_[producer].broken; });
    if (node.present)
        node.state = node.state == StageState::done ? StageState::done : StageState::stored;
    else if (broken)
        node.state = StageState::blocked;
    else if (node.state != StageState::not_needed)
        node.state = StageState::waiting;
}

/// Takes the stage as it is now, and notes whom that concerns.
void RunState::show(std::size_t place)
{
    const StageNode& node = nodes_[place];
    View& view = views_[place];
    const View before = std::exchange(view, {node.result ? node.result->object : "", node.present,
                                             node.state == StageState::failed || node.state == StageState::blocked,
                                             node.selected && node.may_run && !node.present &&
                                                 node.state != StageState::not_needed && node.state != StageState::failed});
    if (view.result != before.result || view.present != before.present || view.broken != before.broken)
        to_look_at_.insert(node.consumers.begin(), node.consumers.end());
    if (view.reads != before.reads)
        to_ask_for_.insert(node.producers.begin(), node.producers.end());
    const bool there = node.state == StageState::done || node.state == StageState::stored;
    if (there && (!before.present || view.result != before.result))
        arrived_.push_back(place);
    const auto is_present = [&](std::size_t producer) { return nodes_[producer].present; };
    if (node.state == StageState::waiting && node.resolved && std::ranges::all_of(node.producers, is_present))
        ready_.insert(place);
    else
        ready_.erase(place);
}

/// Results that no pending stage reads may be missing.
void RunState::ask_for(std::size_t place)
{
    StageNode& node = nodes_[place];
    if (node.state != StageState::waiting && node.state != StageState::not_needed)
        return;
    const bool end = std::ranges::none_of(node.consumers, [&](std::size_t consumer) { return nodes_[consumer].selected; });
    const bool read = std::ranges::any_of(node.consumers, [&](std::size_t consumer) { return views_[consumer].reads; });
    node.state = end || read || node.exports_files ? StageState::waiting : StageState::not_needed;
    if (node.state == StageState::waiting && !node.may_run)
    {
        node.state = StageState::failed;
        node.error = part_->missing_text(*node.stage);
        node.error_code = worker_missing_input;
    }
    show(place);
}

/// Each stage once: first those that read others' results, in their order, then those that are read, from the ends. Once more
/// where it turns out that a result is missing that only others make.
void RunState::settle()
{
    while (!to_look_at_.empty() || !to_ask_for_.empty())
    {
        while (!to_look_at_.empty())
        {
            const std::size_t place = to_look_at_.extract(to_look_at_.begin()).value();
            set_state(nodes_[place]);
            to_ask_for_.insert(place);
            show(place);
        }
        while (!to_ask_for_.empty())
            ask_for(to_ask_for_.extract(std::prev(to_ask_for_.end())).value());
    }
}

void RunState::update()
{
    views_.assign(nodes_.size(), {});
    for (std::size_t place = 0; place < nodes_.size(); ++place)
        to_look_at_.insert(to_look_at_.end(), place);
    settle();
}

void RunState::update(const StageNode& node)
{
    to_look_at_.insert(static_cast<std::size_t>(&node - nodes_.data()));
    settle();
}

}  // namespace fresco::host
