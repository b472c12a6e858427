#pragma once

#include "pipeline/pipeline.h"
#include "run/run_state.h"
#include "store/statistics.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

/// \file Chooses the stages that begin next, by their turn in a matrix, by what earlier runs took, and by free cores and memory.
/// The scheduler uses it.

namespace fresco::host
{

StageKind kind_of(const PipelineStage& stage);

/// Predicts time and memory of a run's stages from earlier runs. Single-threaded.
class Expectations
{
  public:
    explicit Expectations(const Store& store) : statistics_(store) {}

    /// Returns what earlier runs took, without the share of the time that a checkpoint saves. Called often, for thousands of
    /// stages.
    std::optional<Usage> measured(const StageNode& node);
    /// Returns the memory measured with the same options, else the larger of the type's own figure and what other options took;
    /// nothing if neither the memory with these options nor the type's own figure is known.
    std::optional<double> memory_mb(const StageNode& node);
    /// Remembers a finished stage. Throws Error if that cannot be written.
    void remember(const StageNode& node, Usage took);

  private:
    const StageKind& kind(const StageNode& node);

    Statistics statistics_;
    std::map<const StageNode*, StageKind> kinds_;
};

/// Turns of a matrix's combinations: they begin in their order, a limited number at once; a stage may begin with the
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

/// Resources that running stages leave.
struct Room
{
    int cores = 1;
    double memory_mb = 0;  ///< At most so much together; 0: no limit.
    double taken_mb = 0;
    bool idle = true;        ///< No stage is running.
    bool is_closed = false;  ///< A stage of unknown memory runs, which has no neighbors.

    bool fits(std::optional<double> more_mb) const;
    void take(int threads, std::optional<double> more_mb);
};

struct Start
{
    StageNode* node = nullptr;
    int threads = 1;
};

/// Chooses the stages that start now: the first that fit the memory, as many as there are cores, which they share
/// evenly. At least one stage runs; a stage of unknown memory runs alone, and later ones wait. `may_begin`: by place, whose
/// turn it is.
std::vector<Start> choose_starts(RunState& state, const std::vector<bool>& may_begin, Expectations& expected, Room room);

}  // namespace fresco::host
