#pragma once

#include "pipeline/pipeline.h"
#include "pipeline/pipeline_matrix.h"
#include "pipeline/problems.h"

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace fresco::host
{

/// Makes one pipeline of the pipelines of a matrix's combinations. A stage depends on the axes whose vars it needs and on those
/// of the stages it reads; it is there once for each combination of their values, and is named and placed by these.
class SweepMerger
{
  public:
    /// The axes must outlive it.
    explicit SweepMerger(const std::vector<MatrixAxis>& axes) : axes_(axes) {}

    /// One combination: the numbers of its choices, its stages in their order with the vars that each needs, its problems.
    void add(std::vector<std::size_t> choices, std::vector<PipelineStage> stages,
             const std::map<std::string, std::set<std::string>>& vars, const std::vector<Problem>& problems);
    /// Every problem once; one that not all combinations have says which values they have in common.
    void report(ProblemList& problems) const;
    /// Call once, and only where no combination has a problem.
    void merge_into(Pipeline& pipeline);

  private:
    struct Cell
    {
        std::vector<std::size_t> choices;
        std::vector<PipelineStage> stages;
    };

    void spread_axes();
    std::string label(const std::set<std::size_t>& axes, const Cell& cell) const;

    const std::vector<MatrixAxis>& axes_;
    std::vector<Cell> cells_;
    std::map<std::string, std::set<std::size_t>> axes_of_;                ///< By a stage's own name.
    std::vector<std::pair<Problem, std::vector<std::size_t>>> problems_;  ///< With the cells that have it.
    std::map<std::string, std::size_t> known_problems_;
};

}  // namespace fresco::host
