#pragma once

#include "pipeline/pipeline.h"
#include "plugins/catalog.h"
#include "run/scheduler.h"

#include <filesystem>
#include <string>
#include <vector>

namespace fresco::host
{

/// A run that has ended, for its report.
struct ReportRequest
{
    const RunRequest* run = nullptr;
    const RunSummary* summary = nullptr;
    const Catalog* catalog = nullptr;  ///< Where a component that reads and writes pictures is looked for.
    double seconds = 0;                ///< Of the whole run.
    bool interrupted = false;          ///< Who interrupts wants to be gone: no pictures are made.
};

struct ReportOutcome
{
    std::filesystem::path file;
    bool there = false;    ///< It is of this run's results now.
    bool written = false;  ///< False: what is there already says the same.
    std::string note;      ///< Why there is no report, or why something is missing from it; empty: all is well.
};

/// Writes `report.html` into the run's folder of results: the pipeline with times, what every stage came to, frames, losses, the
/// pictures, and the room to turn around; one file that fetches nothing. Of a matrix one for each combination, into the folder of
/// its name. Whole or not at all; not at all where the last report is of the same results, nor in the place of a file that is no
/// report. Pictures are made in a process of its own; where that fails, and where the run was interrupted, the report has none
/// and says so, and the next run writes it again. Never throws because of what it reports about. The host must be
/// single-threaded.
std::vector<ReportOutcome> write_reports(const ReportRequest& request);

/// The child: `fresco internal-report REQUEST.json`. Writes the report; its exit code.
int internal_report(const std::filesystem::path& request_file);

}  // namespace fresco::host
