#pragma once

#include "pipeline/graph.h"
#include "pipeline/pipeline_options.h"

#include <map>
#include <memory>
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
    Position position;  ///< Of its key.
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

std::vector<const PortDeclaration*> pointers(const std::vector<PortDeclaration>& ports);

/// Resolves the `input` of every stage to wires, but for files (see FileInputs), and reports what does not fit.
class Wiring
{
  public:
    Wiring(std::vector<StageDraft>& stages, ProblemList& problems);

    void wire_all();

  private:
    /// What a bare word names.
    struct Source
    {
        std::size_t stage = 0;
        std::string port;  ///< Empty: any.
    };
    using Ports = std::vector<const PortDeclaration*>;

    void wire(StageDraft& stage);
    void wire_one(StageDraft& stage, const YamlNode& node);
    void wire_ports(StageDraft& stage, const YamlNode& map);
    void wire_stage(StageDraft& stage, const Ports& inputs, const YamlNode& node);
    void check_parts(const StageDraft& stage);
    void report_unwired(const StageDraft& stage, const Position& at);
    /// Follows words that are stages' names although no port is known to take them, for the cycle check.
    void follow_blindly(StageDraft& stage, const YamlNode& node);
    bool find_source(StageDraft& stage, const YamlNode& node, Source& source);
    Ports outputs_of(const Source& source, const YamlNode& node, const StageDraft& user);
    /// Whether `stage` is `wanted` or needs it, directly or not.
    bool needs(const StageDraft& stage, const StageDraft& wanted) const;
    std::string makers_of(const PortDeclaration& port, const StageDraft& user) const;

    std::vector<StageDraft>& stages_;
    std::map<std::string, std::size_t, std::less<>> index_;
    ProblemList& problems_;
    std::vector<std::pair<const StageDraft*, Position>> unwired_;  ///< Whose inputs are to be reported, with where.
    bool gave_up_ = false;  ///< On the stage at hand: an input could not be resolved, so that missing ones say nothing.
};

/// The graph of what the stages take from one another. Reports every cycle.
StageGraph check_graph(const std::vector<StageDraft>& stages, ProblemList& problems);

/// Gives a stage whose options declare ports a type of its own with those ports, and reports what keeps its command lines from
/// being run. Where such an option was not understood the stage gets no type: nothing can be said of ports that are not known.
void settle_declared_ports(StageDraft& stage, TypeTable& types, ProblemList& problems);

/// What the costs of a stage are remembered by: its type, and of one that runs a program also that with its first words and
/// files.
std::string cost_name(const PipelineStage& stage);

/// Wires the `{file: PATH}` of a stage's `input` through readers, and reports what does not fit.
class FileInputs
{
  public:
    FileInputs(TypeTable& types, OptionChecker& options, ProblemList& problems)
        : types_(types), options_(options), problems_(problems)
    {
    }

    /// Sets the stage's `wires`, `uses` and `files_failed`.
    void wire(StageDraft& stage);

  private:
    using Ports = std::vector<const PortDeclaration*>;

    bool wire_file(StageDraft& stage, const Ports& inputs, const YamlNode& node);
    std::vector<std::pair<KnownType, const PortDeclaration*>> readers_for(const Ports& inputs, const std::string& extension,
                                                                          const YamlNode& node, const StageDraft& stage);

    TypeTable& types_;
    OptionChecker& options_;
    ProblemList& problems_;
};

}  // namespace fresco::host
