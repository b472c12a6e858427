#pragma once

#include "pipeline/pipeline_axes.h"
#include "pipeline/pipeline_sets.h"
#include "pipeline/pipeline_wiring.h"

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace fresco::host
{

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
struct Cell
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
    Cell cell(const Choices& choices);
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

}  // namespace fresco::host
