#pragma once

#include "pipeline/pipeline.h"
#include "run/run_state.h"
#include "store/statistics.h"

#include <map>
#include <string>
#include <vector>

/// \file Which stages begin next: whose turn it is in a matrix, what they should take, and what fits the cores and the memory.
/// Used by the scheduler.

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
