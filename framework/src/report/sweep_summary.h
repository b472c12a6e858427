#pragma once

#include "plugins/catalog.h"
#include "run/sweep.h"

#include <filesystem>
#include <string>
#include <vector>

namespace fresco::host
{

struct SweepSummaryRequest
{
    const RunRequest* run = nullptr;
    const RunSummary* summary = nullptr;
    const Catalog* catalog = nullptr;  ///< Where a component that reads and writes pictures is looked for.
    std::string pictures;              ///< The stage whose pictures are shown, by its name in the file; empty: see pictures_of.
    const std::vector<CombinationOutcome>* outcomes = nullptr;
};

struct SweepSummaryFiles
{
    std::filesystem::path json;  ///< Empty where a stage writes one of the two itself: theirs is kept.
    std::filesystem::path page;
    std::string note;  ///< Why the page is not as it should be, or not there; empty: all is well.
};

/// Writes `sweep.json` and the page `sweep.html` into the run's folder of results, whole or not at all. The page is left as it is
/// where it shows the same results. Small copies of pictures are made in a process of its own; where that fails the page shows
/// the pictures themselves, and says so. Throws Error if a file cannot be written. The host must be single-threaded.
SweepSummaryFiles write_sweep_summary(const SweepSummaryRequest& request);

/// Numbers in the summary's files of the pictures (PNG, JPEG) that stand for a combination, at most `most`, spread evenly over
/// those of one stage: of `stage` if it is given, else of the last that made some for this combination alone, else of the last.
std::vector<std::size_t> pictures_of(const Pipeline& pipeline, const RunSummary& summary, const CombinationOutcome& outcome,
                                     const std::string& stage, std::size_t most);

/// The child: `fresco internal-sweep REQUEST.json`. Writes the page; its exit code.
int internal_sweep(const std::filesystem::path& request_file);

}  // namespace fresco::host
