#include "run/stage_costs.h"
#include "pipeline/pipeline_ports.h"

namespace fresco::host
{

const CostFigures& StageCosts::expected(const StageNode& node)
{
    const auto [answer, is_new] = answers_.try_emplace(&node);
    if (is_new || answer->second.key != node.key)
        answer->second = {node.key, statistics_.corrected(cost_name(*node.stage), remaining_cost(node, estimates_))};
    return answer->second.cost;
}

void StageCosts::remember(const StageNode& node, const CostFigures& measured) const
{
    record_cost(store_, cost_name(*node.stage), measured, remaining_cost(node, estimates_));
}

}  // namespace fresco::host
