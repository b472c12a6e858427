#pragma once

#include "main/commands.h"
#include "report/report.h"
#include "run/task_table.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

/// \file What the commands about tasks and combinations share: run, status and submit.

namespace fresco::host
{

/// Of a matrix that has run: writes sweep.json and its page beside the results; prints a line per combination if `print`.
/// `thumbnails`: the stage whose pictures the page shows, see SweepSummaryRequest.
void tell_combinations(const ReportRequest& run, const std::string& thumbnails, bool print);

/// What the commands take that cut a pipeline into tasks.
struct TableArguments
{
    PipelineArguments pipeline;
    PlaceArguments places;
    std::string folder = "cluster";
    double pack_minutes = 45;
    int cores = 1;

    /// `file_help`: of the pipeline file.
    void add_to(CLI::App& command, const std::string& file_help);
    std::filesystem::path folder_path() const;
    /// The first of these options that was set, but the file: with a folder that has its tasks already they mean nothing.
    std::string set_option() const;

  private:
    std::vector<CLI::Option*> options_;
};

/// The absolute path of a task folder as the user names it, below which no link is followed any more.
std::filesystem::path guarded_task_folder(const std::filesystem::path& folder);
/// Writes the folder of tasks; the exit code. Prints what is wrong with the pipeline or the places.
int write_tasks(const TableArguments& arguments);
/// The pipeline as it was when the folder's tasks were made. Prints every problem to standard error.
std::unique_ptr<LoadedPipeline> load_tasks(const std::filesystem::path& folder);

}  // namespace fresco::host
