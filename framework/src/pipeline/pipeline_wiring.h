#pragma once

#include "pipeline/graph.h"
#include "pipeline/pipeline_options.h"

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

/// \file The inputs of stages: which stage's output or which file each port gets, and ports that options declare. Used where
/// a pipeline is checked.

namespace fresco::host
{

/// A stage while the pipeline is checked.
struct StageDraft
{
    std::string name;
    Position position;  ///< Position of its key.
    YamlNode config;    ///< A map, everything substituted.
    KnownType type;     ///< Empty after a problem.
    std::shared_ptr<const TypeDescription> own_type;
    Value options;
    OptionUses uses;
    std::vector<Wire> wires;  ///< In the declared order of the ports.
    /// A part that an option has a rule for, and the input that is to have it.
    struct PartUse
    {
        std::string part;
        std::string option;
        std::string port;
        Position position;
    };
    std::vector<PartUse> part_uses;
    bool files_failed = false;  ///< A file among its inputs could not be wired.
    /// The stages whose names its inputs hold, with where: for the graph, whatever else is wrong.
    std::vector<std::pair<std::size_t, Position>> sources;

    /// "stage 'mesh' (mesh.decimate)".
    std::string title() const;
};

/// Whether the whole `input` is one file.
bool is_file_input(const YamlNode& input, const TypeDeclaration& type);

/// Resolves the `input` of every stage to wires, but for files (see wire_files), and reports what does not fit. `dropped`: stages
/// that `--without` left out.
void wire_stages(std::vector<StageDraft>& stages, const std::set<std::string>& dropped, ProblemList& problems);

/// The graph of what the stages take from one another. Reports every cycle.
StageGraph check_graph(const std::vector<StageDraft>& stages, ProblemList& problems);

/// Gives a stage whose options declare ports a type of its own with those ports, and reports what keeps its command lines from
/// being run. Where such an option was not understood the stage gets no type: nothing can be said of ports that are not known.
void settle_declared_ports(StageDraft& stage, TypeTable& types, ProblemList& problems);

/// The stage's type; of one that runs a program also that program with its first words and files.
std::string program_name(const PipelineStage& stage);

/// Wires the `{file: PATH}` of a stage's `input` through readers, and reports what does not fit. Sets the stage's `wires`, `uses`
/// and `files_failed`.
void wire_files(StageDraft& stage, TypeTable& types, OptionChecker& options, ProblemList& problems);

}  // namespace fresco::host
