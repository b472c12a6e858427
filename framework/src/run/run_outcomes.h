#pragma once

#include "run/running_stage.h"

#include "run/progress_display.h"
#include "run/run_state.h"

#include <map>
#include <string>
#include <vector>

namespace fresco::host
{

/// What the stages of one run came to, shown as each ends. One thread.
class RunOutcomes
{
  public:
    /// The display must outlive it.
    explicit RunOutcomes(ProgressDisplay& display) : display_(display) {}

    /// What it took, of a stage whose process ended well.
    void take_figures(const RunningStage& running);
    /// Where the figures of any other are put before it ends.
    StageOutcome& of(const StageNode& node);
    /// The stage has come to its state: shows it.
    void end(const StageNode& node);
    /// Of all stages that were selected, in their order; what failed before it could begin is shown now.
    std::vector<StageOutcome> all(const std::vector<StageNode>& nodes);

  private:
    ProgressDisplay& display_;
    std::map<std::string, StageOutcome> outcomes_;
};

/// The exit code for what failed, 0 if nothing did. That a stage itself failed counts for more than that an input was missing.
int exit_code_of(const std::vector<StageNode>& nodes);

}  // namespace fresco::host
