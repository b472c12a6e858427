#pragma once

#include "pipeline/pipeline.h"
#include "run/run_state.h"

#include <vector>

namespace fresco::host
{

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

}  // namespace fresco::host
