#pragma once

#include "store/store.h"

#include <map>
#include <string>
#include <vector>

/// \file What stages took in earlier runs, by which estimates are corrected.

namespace fresco::host
{

/// What a stage takes; for one run, or expected.
struct CostFigures
{
    double seconds = 0;
    double memory_mb = 0;
    double disk_mb = 0;
};

/// Remembers what a stage of this type took, together with what its Stage::cost() had said for the same work, in the store's
/// Journal stats.jsonl. Throws Error where that cannot be written.
void record_cost(const Store& store, const std::string& type, const CostFigures& measured, const CostFigures& estimated);

/// Keeps only the costs of the last runs of each type. Throws Error.
void tidy_costs(const Store& store);

/// Costs of earlier runs in this store.
class Statistics
{
  public:
    explicit Statistics(const Store& store);
    bool knows(const std::string& type) const;
    /// Stage::cost()'s figures, corrected by what earlier runs of the type took against theirs (median ratio). Where it said
    /// nothing, the median of what was measured.
    CostFigures corrected(const std::string& type, const CostFigures& estimated) const;

  private:
    std::map<std::string, std::vector<Value>> runs_;  ///< By type, the last ones, oldest first.
};

}  // namespace fresco::host
