#include "run/run_state.h"
#include "run/exports.h"
#include "run/result_key.h"
#include <fresco/error.h>

#include <algorithm>

namespace fresco::host
{

std::string_view to_string(StageState state)
{
    switch (state)
    {
    case StageState::not_selected:
        return "not selected";
    case StageState::not_needed:
        return "not needed";
    case StageState::stored:
        return "stored";
    case StageState::waiting:
        return "waiting";
    case StageState::running:
        return "running";
    case StageState::done:
        return "ran";
    case StageState::failed:
        return "failed";
    case StageState::blocked:
        return "not run";
    case StageState::interrupted:
        return "interrupted";
    }
    return "";
}

CostFigures remaining_cost(const StageNode& node, const std::map<std::string, CostFigures>& estimates)
{
    const auto found = estimates.find(node.stage->name);
    CostFigures cost = found == estimates.end() ? CostFigures{} : found->second;
    cost.seconds *= 1 - node.done_share;
    return cost;
}

RunState::RunState(const Pipeline& pipeline, const Store& store, FileHashes& hashes, const std::string& until)
    : store_(store), hashes_(hashes), until_(until)
{
    std::map<std::string, std::size_t> places;
    for (const auto& stage : pipeline.stages)
    {
        StageNode node;
        node.stage = &stage;
        node.exports_files = !files_outputs(stage).empty();
        node.selected = until.empty();
        for (const auto& wire : stage.wires)
            if (!wire.from_stage.empty())
            {
                const std::size_t producer = places.at(wire.from_stage);
                if (std::find(node.producers.begin(), node.producers.end(), producer) == node.producers.end())
                {
                    node.producers.push_back(producer);
                    nodes_[producer].consumers.push_back(nodes_.size());
                }
            }
        places[stage.name] = nodes_.size();
        nodes_.push_back(std::move(node));
    }
    if (until.empty())
        return;
    bool found = false;
    for (StageNode& node : nodes_)
        if (node.stage->own_name == until)
            found = node.selected = true;
    if (!found)
        throw Error("--until " + until + ": the pipeline has no stage of this name");
    for (std::size_t i = nodes_.size(); i-- > 0;)
        if (nodes_[i].selected)
            for (const std::size_t producer : nodes_[i].producers)
                nodes_[producer].selected = true;
}

StageNode* RunState::find(std::string_view stage)
{
    const auto found =
        std::find_if(nodes_.begin(), nodes_.end(), [&](const StageNode& node) { return node.stage->name == stage; });
    return found == nodes_.end() ? nullptr : &*found;
}

bool RunState::ready(const StageNode& node) const
{
    return std::all_of(node.producers.begin(), node.producers.end(),
                       [&](std::size_t producer) { return nodes_[producer].present; });
}

void RunState::resolve(StageNode& node)
{
    std::map<std::string, std::string> upstream;
    for (const std::size_t producer : node.producers)
    {
        if (!nodes_[producer].result)
        {
            node.resolved = false;
            node.result.reset();
            node.present = false;
            return;
        }
        upstream[nodes_[producer].stage->name] = nodes_[producer].result->object;
    }
    if (!node.resolved || node.upstream != upstream)
    {
        node.key_document = key_document(*node.stage, upstream, hashes_);
        node.key = key_of(node.key_document);
        node.done_share = store_.checkpoint_share(node.key);
        node.upstream = std::move(upstream);
        node.resolved = true;
        node.why_not.clear();
        node.result = store_.lookup(node.key, &node.why_not);
    }
    node.present = node.result && store_.present(*node.result);
}

void RunState::update()
{
    const auto fixed = [](StageState state)
    { return state == StageState::running || state == StageState::failed || state == StageState::interrupted; };
    for (auto& node : nodes_)
    {
        if (!node.selected)
            node.state = StageState::not_selected;
        if (!node.selected || fixed(node.state))
            continue;
        const bool broken = std::any_of(node.producers.begin(), node.producers.end(),
                                        [&](std::size_t producer)
                                        {
                                            const StageState state = nodes_[producer].state;
                                            return state == StageState::failed || state == StageState::blocked;
                                        });
        const bool was_done = node.state == StageState::done;
        try
        {
            resolve(node);
        }
        catch (const MissingInput& error)
        {
            node.state = StageState::failed;
            node.error = error.what();
            node.error_code = 3;
            continue;
        }
        if (node.present)
            node.state = was_done ? StageState::done : StageState::stored;
        else
            node.state = broken ? StageState::blocked : StageState::waiting;
    }
    // From the ends: what nobody who must run reads need not be there.
    for (std::size_t i = nodes_.size(); i-- > 0;)
    {
        StageNode& node = nodes_[i];
        if (node.state != StageState::waiting)
            continue;
        bool end = true;
        bool read = false;
        for (const std::size_t consumer : node.consumers)
        {
            const StageNode& reader = nodes_[consumer];
            end = end && !reader.selected;
            read = read || (reader.selected && !reader.present && reader.state != StageState::not_needed);
        }
        if (!end && !read && !node.exports_files)
            node.state = StageState::not_needed;
    }
}

}  // namespace fresco::host
