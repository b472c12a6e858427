#pragma once

#include "pipeline/pipeline_matrix.h"
#include "pipeline/pipeline_sets.h"
#include "pipeline/pipeline_wiring.h"

#include <bitset>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

/// \file Makes the stages of all combinations of a matrix out of the stages of the file, each only once for all combinations
/// that it is the same in. Used by load_pipeline.

namespace fresco::host
{

/// Axes by their numbers.
using AxisSet = std::bitset<axis_limit>;

/// For each axis the number of its value.
using Choices = std::vector<std::size_t>;

/// The choices of some axes, as a key: equal where those agree.
Choices chosen_of(const AxisSet& axes, const Choices& choices);
/// What they are called: "kitchen,waves".
std::string label_of(const AxisSet& axes, const Choices& choices, const std::vector<MatrixAxis>& matrix);

/// Which vars of a document depend on which axes, directly or through other vars and the axes' values, and which nobody uses.
class VarUse
{
  public:
    VarUse(const YamlNode& vars, const std::vector<MatrixAxis>& axes);

    /// The axes that text with these vars in it depends on; from now on they, and what they are made of, are in use.
    AxisSet use(const std::set<std::string>& names);
    /// The vars that are not in use, by the axes that they depend on.
    std::map<unsigned long, std::set<std::string>> unused() const;

  private:
    struct Var
    {
        std::vector<std::size_t> made_of;
        AxisSet axes;
        bool in_use = false;
    };

    std::vector<std::string> names_;
    std::map<std::string, std::size_t> index_;
    std::vector<Var> vars_;
};

/// A stage as all combinations have it that agree in the axes whose vars it names.
struct CheckedStage
{
    std::size_t shape = 0;
    std::shared_ptr<const Value> options;
    std::vector<std::filesystem::path> input_files;  ///< Sorted, unique.
    std::vector<const TypeDescription*> components;  ///< Sorted by type, unique.
    std::vector<OptionUses::OutputUse> output_names;
    std::vector<Wire> files;  ///< The inputs that are files.
};

/// What one combination is made of.
struct CombinationDraft
{
    Choices choices;
    std::vector<std::size_t> stages;   ///< Per stage of the file, the number of its CheckedStage.
    std::vector<std::size_t> batches;  ///< Whose problems it has.
};

/// The stages of a pipeline file, substituted and checked: each once for all combinations that it is the same in. Stages that
/// differ between combinations only in options and files have one shape, and are wired alike.
class StageDrafts
{
  public:
    /// All of them must outlive it.
    StageDrafts(const PipelineDocument& document, const std::vector<MatrixAxis>& matrix, const Settings& settings,
                TypeTable& types);

    /// The axes whose vars a stage names, directly or through other vars.
    const AxisSet& axes_of(std::size_t stage) const { return axes_[stage]; }
    CombinationDraft cell(const Choices& choices);
    const CheckedStage& stage(std::size_t number) const { return stages_[number]; }
    /// With name, type, `input` and position, and with the files of one of the stages among its wires.
    const StageDraft& shape(std::size_t number) const { return shapes_[number]; }
    const std::vector<Problem>& problems(std::size_t batch) const { return problems_[batch]; }

  private:
    /// Stages and unused vars that depend on the same axes: checked together, with one budget for what vars grow to.
    struct Group
    {
        AxisSet axes;
        std::vector<std::size_t> stages;
        std::set<std::string> unused_vars;
        std::map<Choices, std::size_t> batches;
    };
    std::size_t make_batch(const Group& group, const Choices& choices);
    void add_stage(std::size_t stage, YamlNode config, OptionChecker& checker, ProblemList& problems);
    std::size_t shape_of(std::size_t stage, StageDraft draft);

    const PipelineDocument& document_;
    const std::vector<MatrixAxis>& matrix_;
    const Settings& settings_;
    TypeTable& types_;
    std::vector<AxisSet> axes_;
    std::vector<Group> groups_;
    std::vector<std::size_t> first_stages_;       ///< Per batch.
    std::vector<std::vector<Problem>> problems_;  ///< Per batch.
    std::vector<CheckedStage> stages_;
    std::vector<StageDraft> shapes_;
    std::map<std::string, std::size_t> known_shapes_;
};

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
        CombinationDraft cell;
        const Structure* structure = nullptr;
    };

    const Structure& structure_of(const CombinationDraft& cell);
    std::vector<Problem> colliding_outputs(const CombinationDraft& cell) const;
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
