#include "run/stage_standings.h"

namespace fresco::host
{

std::filesystem::path preview_folder(const std::filesystem::path& out, const PipelineStage& stage)
{
    return out / stage.place / "preview" / stage.own_name;
}

void StageStandings::show(const std::vector<StageNode>& nodes, bool running, int cores)
{
    if (running && Clock::now() - last_ < std::chrono::milliseconds(100))
        return;
    last_ = Clock::now();
    std::vector<StageStanding> stages;
    shown_.resize(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i)
    {
        const StageNode& node = nodes[i];
        if (shown_[i] != node.state)
            stages.push_back({node.stage->name, node.state, costs_.expected(node).seconds, preview_folder(out_, *node.stage)});
        shown_[i] = node.state;
    }
    if (!stages.empty())
        display_.stages(stages, cores);
}

}  // namespace fresco::host
