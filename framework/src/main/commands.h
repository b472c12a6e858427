#pragma once

#include "pipeline/pipeline.h"
#include "plugins/catalog.h"
#include "store/store.h"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

/// \file The commands of the program, and what several of them share: the arguments of a pipeline file and of the places
/// where results go.

namespace fresco::host
{

/// Each adds one command; when it is the one chosen, it leaves the program's exit code in `exit_code`.
/// `words`: of the whole command line, for the run's report.
void add_run_command(CLI::App& app, const std::vector<std::string>& words, int& exit_code);
void add_inspect_commands(CLI::App& app, int& exit_code);
void add_plan_command(CLI::App& app, int& exit_code);
void add_store_command(CLI::App& app, int& exit_code);
void add_doctor_command(CLI::App& app, int& exit_code);
void add_reference_command(CLI::App& app, int& exit_code);
void add_new_commands(CLI::App& app, int& exit_code);
void add_completion_commands(CLI::App& app);
void add_internal_commands(CLI::App& app, int& exit_code);
void add_manual_command(CLI::App& app);

/// The command of this name directly below `app`, or nullptr if there is none.
const CLI::App* command_named(const CLI::App& app, const std::string& name);
/// The commands that are programs of their own, sorted.
std::vector<std::string> program_commands();
/// Replaces this process by the program `fresco-NAME` of the command NAME = `words[1]`; returns if there is no such program.
/// Throws Error if it cannot be run.
void run_program_command(char** words);
/// Completions of the last of `words`, which begin with the name of a program beside fresco: it is asked by
/// `fresco-NAME internal-complete WORDS`, and prints lines as completions() gives them.
std::vector<std::string> program_completions(const std::vector<std::string>& words);
/// Names of the programs beside fresco, and what they print for --help-all.
std::vector<std::pair<std::string, std::vector<std::string>>> program_helps();

/// The schema of pipeline files that is installed with this program; it may be missing.
std::filesystem::path installed_schema();

/// Invalid arguments. The text is printed unchanged, and the exit code is 2.
struct UsageError : std::runtime_error
{
    using std::runtime_error::runtime_error;
};

/// Arguments of every command that works on a pipeline file.
struct PipelineArguments
{
    std::string file;  ///< "-": `given_text` is the pipeline, its relative paths those of the working directory.
    std::optional<std::string> given_text;  ///< Text of standard input.
    std::string text_file;                  ///< Read in place of `file`; empty: none.
    std::vector<std::string> sets;
    std::vector<std::string> without;
    std::string until;
    bool preview = false;

    void add_to(CLI::App& command);
    void add_until_to(CLI::App& command);
    PipelineRequest request() const;
};

/// Destinations of results.
struct PlaceArguments
{
    std::string out;  ///< Empty: not given, see out_name.
    std::string store = default_store;
    bool replace = false;

    void add_store_to(CLI::App& command);
    void add_out_to(CLI::App& command);
    /// As the user would write it.
    std::string out_name() const;
    std::filesystem::path out_folder() const;
    std::filesystem::path store_folder() const;
    /// Never creates a store: throws MissingInput if there is none.
    Store existing_store() const;
    /// Throws UsageError where a run could not keep or write its results there. Called before anything runs.
    void check() const;

  private:
    const CLI::App* command_ = nullptr;  ///< With --out.
};

/// Prints JSON for machines, indented.
void print_value(const Value& value);

/// A checked pipeline with the catalog that it points into.
struct LoadedPipeline
{
    Catalog catalog;
    PipelineResult result;
};
/// Prints what a run should say of the plugin folders.
void warn_of_plugin_folders();
/// Loads a pipeline and prints every problem to standard error.
std::unique_ptr<LoadedPipeline> load_and_report(const PipelineRequest& request);

}  // namespace fresco::host
