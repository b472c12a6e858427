#pragma once

#include "plugins/catalog.h"
#include <fresco/value.h>

#include <filesystem>
#include <iosfwd>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// \file A pipeline file, checked and complete: what every command works on. load_pipeline() is the way in; it reports all
/// problems at once.

namespace fresco::host
{

/// A place in a pipeline file; line and column count from 1. For `--set`, the file is "--set NAME=…" and the line 0.
struct Position
{
    std::string file;
    int line = 0;
    int column = 0;

    friend auto operator<=>(const Position&, const Position&) = default;
};

/// The exit code a problem leads to.
enum class ProblemKind
{
    warning = 0,
    invalid = 2,
    missing_input = 3,
    plugin = 4
};

struct Problem
{
    Position position;
    std::string text;
    ProblemKind kind = ProblemKind::invalid;
};

/// "file:line:column: error: text" ("--set x=…: error: text" without a line).
std::string to_string(const Problem& problem);

class StageGraph;
struct YamlNode;

/// Source of one input port: another stage's output, or a user's file through a reader.
struct Wire
{
    std::string port;
    std::string artifact;
    std::string from_stage;  ///< Empty for a file.
    std::string from_port;
    std::filesystem::path file;  ///< Absolute; empty for a stage.
    Value reader;                ///< {type: read.image, options…}, complete.
};

struct PipelineStage
{
    /// Unique name: that in the file, and after an '@' the values of the axes that the stage depends on.
    std::string name;
    std::string own_name;  ///< In the file. Several stages of a matrix have one.
    std::string place;     ///< Folder below `--out` for what it makes: the values of its axes ("kitchen,waves"), else empty.
    const TypeDescription* type = nullptr;  ///< Owned by the catalog, or by `own_type`.
    /// Type of a stage that declares its ports in the pipeline file (`type: command`).
    std::shared_ptr<const TypeDescription> own_type = {};
    /// Every option with its value: defaults filled in, component configurations complete down to their own options, `auto`
    /// expanded, paths absolute. What the worker process configures the stage with.
    std::shared_ptr<const Value> options;  ///< Shared with the stages of a matrix that have the same.
    std::vector<Wire> wires;
    std::vector<std::filesystem::path> input_files;  ///< Files of InputFile options (components' too) and of wires.
    struct Output
    {
        std::string name;  ///< Below `place` in `--out`.
        bool is_file;      ///< Otherwise it may be a folder.
        std::string option;
        Position position;
    };
    std::vector<Output> outputs;                     ///< Files and folders that its options, and those of its components, name.
    std::vector<const TypeDescription*> components;  ///< Every component type it uses, readers too, sorted, unique.
    /// The file's `components`, substituted.
    std::shared_ptr<const YamlNode> chosen_components;
    Position position;  ///< The place of the stage's key.
};

/// One cell of a matrix: a value for each axis.
struct Combination
{
    std::string name;                 ///< "kitchen,waves": what its values are called.
    std::vector<std::string> values;  ///< Label of each axis's value, in the order of the axes.
    std::vector<std::size_t> stages;  ///< Numbers of the stages it is made of, shared ones too.
};

/// Contents of `matrix`.
struct Sweep
{
    std::vector<std::string> axes;  ///< Vars. Empty: there is no matrix.
    std::vector<Combination> combinations;
    /// By a stage's own name: the axes that it depends on. Without those that depend on none.
    std::map<std::string, std::vector<std::string>> stage_axes;
    bool narrowed = false;  ///< Some combinations were left out.
};

/// A pipeline file as it was read.
struct PipelineText
{
    std::filesystem::path file;
    std::string text;
};

/// A checked pipeline: stages in a topological order that keeps the file's order where it can, but for those that come early
/// because rules of others depend on what they make. With a matrix, the stages of all
/// combinations; one that does not depend on an axis is there once for all the axis's values.
struct Pipeline
{
    std::filesystem::path file;
    std::vector<PipelineText> texts;  ///< The file, and those that it builds on.
    std::vector<PipelineStage> stages;
    std::shared_ptr<const StageGraph> graph;  ///< Dependencies, by places in `stages`.
    Sweep sweep;

    const PipelineStage* find(std::string_view name) const;
};

struct PipelineRequest
{
    std::filesystem::path file;
    std::vector<std::pair<std::string, std::string>> sets;  ///< `--set NAME=VALUE`, `--set stage.option=VALUE`, in order.
    std::filesystem::path working_directory;                ///< Base of relative paths in `sets`.
    std::string until = {};                                 ///< `--until STAGE`: checked to be a stage's name; empty: not given.
    bool preview = false;                                   ///< `--preview`: with the options that the file's `preview` sets.
    std::vector<PipelineText> texts = {};                   ///< If not empty: read instead of the files on the disk.
    std::vector<std::string> without = {};                  ///< `--without STAGE`: left out of the file.
    bool keep_going = false;                                ///< Combinations that lack an input are left out if others remain.
};

/// Either a pipeline without problems, or problems (all of them, in the file's order) and no stages.
struct PipelineResult
{
    Pipeline pipeline;
    std::vector<Problem> problems;
    std::vector<Problem> warnings = {};
    std::vector<Problem> left_out = {};  ///< Missing inputs of the combinations that --keep-going leaves out.
    /// 0, or the largest claim among the problems: 2 before 4 before 3.
    int exit_code() const;
};

/// Reads, checks and completes a pipeline file against the catalog. Runs no plugin code.
PipelineResult load_pipeline(const PipelineRequest& request, const Catalog& catalog);

/// Stages by the paths that they write below `--out`: no two may write the same, nor one into a folder that another writes as a
/// file.
class OutputOwners
{
  public:
    /// Notes that the stage writes `path`, relative to `--out`: a file, or a folder of files. If another stage is in the way,
    /// says so, and that another value of `option` helps.
    std::optional<std::string> claim(const std::filesystem::path& path, const std::string& stage, bool is_file,
                                     const std::string& option = "path");

  private:
    struct Owner
    {
        std::string stage;
        bool is_file;
    };
    using Owners = std::map<std::filesystem::path, Owner>;
    static std::string blocked(const Owners::value_type& file, const Owners::value_type& below, const std::string& option);

    Owners owners_;
};

}  // namespace fresco::host
