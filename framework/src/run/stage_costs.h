#pragma once

#include "run/run_state.h"
#include "store/statistics.h"

#include <map>
#include <string>

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

}  // namespace fresco::host
