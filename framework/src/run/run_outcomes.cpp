#include "run/run_outcomes.h"
#include "run/stage_failure.h"

#include "worker/worker.h"

namespace fresco::host
{

StageOutcome& RunOutcomes::of(const StageNode& node)
{
    return outcomes_[node.stage->name];
}

void RunOutcomes::take_figures(const RunningStage& running)
{
    StageOutcome& outcome = of(running.node());
    outcome.seconds = running.seconds();
    outcome.memory_mb = running.memory_mb();
    outcome.disk_mb = running.disk_mb();
    outcome.threads = running.threads();
}

void RunOutcomes::end(const StageNode& node)
{
    StageOutcome& outcome = of(node);
    outcome.stage = node.stage->name;
    outcome.type = node.stage->type->type;
    outcome.state = node.state;
    outcome.object = node.present && node.result ? node.result->object : "";
    if (node.state == StageState::failed)
        outcome.error = stage_error_text(*node.stage, node.error);
    display_.stage_ends(outcome);
}

std::vector<StageOutcome> RunOutcomes::all(const std::vector<StageNode>& nodes)
{
    std::vector<StageOutcome> result;
    for (const StageNode& node : nodes)
    {
        if (node.state == StageState::not_selected)
            continue;
        if (node.state == StageState::failed && !outcomes_.contains(node.stage->name))
            end(node);
        StageOutcome outcome = of(node);
        outcome.stage = node.stage->name;
        outcome.type = node.stage->type->type;
        outcome.key = node.key;
        outcome.state = node.state == StageState::waiting ? StageState::blocked : node.state;
        if (node.present && node.result)
            outcome.object = node.result->object;
        result.push_back(std::move(outcome));
    }
    return result;
}

int exit_code_of(const std::vector<StageNode>& nodes)
{
    int code = 0;
    for (const StageNode& node : nodes)
        if (node.state == StageState::failed)
            code = code == 0 || node.error_code == worker_failed ? node.error_code : code;
    return code;
}

}  // namespace fresco::host
