#pragma once

#include "pipeline/pipeline.h"
#include "run/progress_display.h"
#include "run/run_state.h"
#include "store/statistics.h"

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// \file Which stages begin next: whose turn it is in a matrix, what fits the cores and the memory, and what is known of
/// costs and waiting. Used by the scheduler.

namespace fresco::host
{

/// What the stages of one run should take, and what they took. One thread.
class StageCosts
{
  public:
    /// `estimates`: per stage, by its own account. It and the store must outlive this.
    StageCosts(const Store& store, const std::map<std::string, CostFigures>& estimates)
        : store_(store), estimates_(estimates), statistics_(store)
    {
    }

    /// What is left of the stage's work takes that, by its own account and earlier runs. Asked for often, of thousands.
    const CostFigures& expected(const StageNode& node);
    /// Keeps what it took for later runs. Throws Error where that cannot be written.
    void remember(const StageNode& node, const CostFigures& measured) const;

  private:
    struct Answer
    {
        std::string key;  ///< It was given for.
        CostFigures cost;
    };

    const Store& store_;
    const std::map<std::string, CostFigures>& estimates_;
    Statistics statistics_;
    std::map<const StageNode*, Answer> answers_;
};

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

/// Whose turn it is among the combinations of a matrix: they begin in their order, so many at once; a stage may begin with the
/// first of its combinations. Without a matrix every stage may begin.
class SweepTurns
{
  public:
    /// The sweep must outlive it.
    SweepTurns(const Sweep& sweep, int jobs, bool keep_going);

    /// For each stage whether it may begin now.
    std::vector<bool> take(const std::vector<StageNode>& stages);
    /// Whether combinations were left out because one failed.
    bool ended_early() const { return ended_early_; }

  private:
    const Sweep& sweep_;
    int jobs_;
    bool keep_going_;
    std::vector<bool> begun_;  ///< Per combination.
    bool ended_early_ = false;
};

/// What running stages leave of the machine.
struct Room
{
    int cores = 1;
    double memory_mb = 0;  ///< At most so much together; 0: no limit.
    double taken_mb = 0;
    bool idle = true;  ///< No stage is running.

    void take(int threads, double more_mb);
};

struct Start
{
    StageNode* node = nullptr;
    int threads = 1;
};

/// Which of the stages that may begin start now: the first that fit the memory, as many as there are cores, which they share
/// evenly. One may always run. `may_begin`: by place, whose turn it is.
std::vector<Start> choose_starts(RunState& state, const std::vector<bool>& may_begin, StageCosts& costs, Room room);

}  // namespace fresco::host
