#pragma once

#include "pipeline/pipeline_drafts.h"

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace fresco::host
{

/// Makes one pipeline of a matrix's combinations; without a matrix there is one, which has no values. A stage depends on the axes
/// whose vars it names and on those of the stages it reads; it is there once for each combination of their values, and is named
/// and placed by these. Stages of one shape are wired once.
class SweepBuilder
{
  public:
    /// All of them must outlive it.
    SweepBuilder(const PipelineDocument& document, const std::vector<MatrixAxis>& matrix, StageDrafts& drafts)
        : document_(document), matrix_(matrix), drafts_(drafts)
    {
    }

    void add(const Choices& choices);
    /// Every problem once; one that not all combinations have says which values they have in common.
    void report(ProblemList& problems) const;
    /// Call once, and only where no combination has a problem. `axes`: by a stage's name, those that it depends on beyond what
    /// the added combinations show.
    void build(Pipeline& pipeline, const std::map<std::string, AxisSet>& axes);

  private:
    /// How stages of these shapes are wired.
    struct Structure
    {
        std::vector<std::size_t> order;
        std::vector<std::vector<Wire>> wires;  ///< Per stage; only from stages, by their names in the file.
        std::vector<Problem> problems;
    };
    struct Member
    {
        Cell cell;
        const Structure* structure = nullptr;
    };

    const Structure& structure_of(const Cell& cell);
    std::vector<Problem> colliding_outputs(const Cell& cell) const;
    void note(const std::vector<Problem>& problems);
    std::vector<AxisSet> spread_axes(const std::map<std::string, AxisSet>& axes) const;
    PipelineStage stage_of(const Member& member, std::size_t stage, const std::vector<AxisSet>& axes) const;
    std::string name_of(std::size_t stage, const Choices& choices, const std::vector<AxisSet>& axes) const;

    const PipelineDocument& document_;
    const std::vector<MatrixAxis>& matrix_;
    StageDrafts& drafts_;
    std::map<std::vector<std::size_t>, Structure> structures_;  ///< By the shapes.
    std::map<std::string, std::size_t> numbers_;                ///< Of stages, by name.
    std::vector<Member> members_;
    std::vector<std::pair<Problem, std::vector<std::size_t>>> problems_;  ///< With the members that have it.
    std::map<std::string, std::size_t> known_problems_;
};

}  // namespace fresco::host
