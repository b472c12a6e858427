#pragma once

#include "pipeline/pipeline.h"
#include "plugins/catalog.h"
#include "run/scheduler.h"
#include "run/sweep.h"

#include <filesystem>
#include <string>
#include <vector>

/// \file The report of a run, for people (report.html) and for programs (run.json), and that of a matrix: sweep.json, and a page
/// of small pictures.

namespace fresco::host
{

/// A run that has ended, for its report.
struct ReportRequest
{
    const RunRequest* run = nullptr;
    const RunSummary* summary = nullptr;
    const Catalog* catalog = nullptr;  ///< Plugins for previews.
    std::vector<std::string> command;  ///< Words of the command line.
    double seconds = 0;                ///< Duration of the whole run.
    bool interrupted = false;          ///< The user interrupted the run: no pictures are made.
};

struct ReportOutcome
{
    std::filesystem::path file;
    bool there = false;    ///< It is of this run's results now.
    bool written = false;  ///< False: what is there already says the same.
    std::string note;      ///< Why there is no report, or why something is missing from it; empty: all is well.
};

/// Writes `run.json` (pipelines/results.md) and `report.html`, a page that draws it, into the run's folder of results. Of a
/// matrix both for each combination, into the folder of its name. Each whole or not at all; not at all where the last are of the
/// same results, nor in the place of a file that fresco did not write, or that changed since. Where pictures cannot be made, and
/// where the run was interrupted, the page has none and says so, and the next run writes it again. Never throws because of what
/// it reports about. The host must be single-threaded.
std::vector<ReportOutcome> write_reports(const ReportRequest& request);

/// Why the run could not write its report, or the summary of its matrix: the user's own files are in the way. Without reports,
/// `reports` is false.
std::vector<std::string> report_obstacles(const RunRequest& run, bool reports);

struct SweepSummaryFiles
{
    std::filesystem::path json;  ///< Empty if not written; the note says why.
    std::filesystem::path page;
    std::string note;  ///< Why the page is not as it should be, or not there; empty: all is well.
};

/// Writes `sweep.json` (pipelines/results.md) and `sweep.html`, a page that draws it, into the run's folder of results, whole or
/// not at all; neither in the place of a file that fresco did not write. The page is left as it is where it shows the same
/// results. Where small copies of pictures cannot be made the page shows the files themselves, and says so. The host must be
/// single-threaded. `pictures`: the stage whose pictures are shown, by its name in the file; empty: see pictures_of.
SweepSummaryFiles write_sweep_summary(const ReportRequest& run, const std::vector<CombinationOutcome>& outcomes,
                                      const std::string& pictures);

/// The pictures, by their `extensions`, that represent a combination, as indices into the summary's files: at most `most` of
/// them, evenly spaced, all from one stage. That is `stage` if given, else the last stage with pictures of only this combination,
/// else the last stage with pictures.
std::vector<std::size_t> pictures_of(const Pipeline& pipeline, const RunSummary& summary, const CombinationOutcome& outcome,
                                     const std::vector<std::string>& extensions, const std::string& stage, std::size_t most);

/// Common part of run.json and sweep.json (pipelines/results.md).
/// Format, versions, time, command and pipeline; `format` is "fresco-run" or "fresco-sweep".
Value::Map origin_data(const ReportRequest& request, const char* format);

/// A stage's entry of "stages": what it came to, and how it was made. A manifest that cannot be read leaves its figures empty.
Value stage_data(const PipelineStage& stage, const StageOutcome* outcome, const Store& store);

/// The child: `fresco internal-page REQUEST.json`. Opens plugins, loads artifacts, lets their viewers show them, and writes the
/// page; its exit code.
int internal_page(const std::filesystem::path& request_file);

}  // namespace fresco::host
