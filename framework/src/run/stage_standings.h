#pragma once

#include "run/progress_display.h"
#include "run/run_state.h"
#include "run/stage_costs.h"

#include <chrono>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace fresco::host
{

/// Where a stage's previews go while it runs.
std::filesystem::path preview_folder(const std::filesystem::path& out, const PipelineStage& stage);

/// Keeps a display informed of the states of all stages. One thread.
class StageStandings
{
  public:
    /// The display and the costs must outlive it. `out`: where the run exports to.
    StageStandings(ProgressDisplay& display, StageCosts& costs, std::filesystem::path out)
        : display_(display), costs_(costs), out_(std::move(out))
    {
    }

    /// Shows the stages whose state has changed. There may be thousands: while some are `running`, ten times a second at most.
    void show(const std::vector<StageNode>& nodes, bool running, int cores);

  private:
    using Clock = std::chrono::steady_clock;

    ProgressDisplay& display_;
    StageCosts& costs_;
    std::filesystem::path out_;
    std::vector<std::optional<StageState>> shown_;
    Clock::time_point last_;
};

}  // namespace fresco::host
