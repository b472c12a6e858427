#pragma once

#include "report/report.h"
#include "run/sweep.h"

#include <filesystem>
#include <string>
#include <vector>

/// \file The report of a matrix: sweep.json, and a page of small pictures.

namespace fresco::host
{

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

}  // namespace fresco::host
