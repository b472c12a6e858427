#pragma once

#include "pipeline/pipeline.h"
#include "run/exports.h"
#include "run/progress_display.h"
#include "run/run_state.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

/// \file Runs a pipeline: the way in for `fresco run`, for tasks, and for tests.

namespace fresco::host
{

/// Limits of each stage's process with all that it starts. 0: no limit.
struct StageLimits
{
    double memory_mb = 0;  ///< Resident, all processes together; and what each of them maps for writing.
    double seconds = 0;    ///< From the moment the stage begins.
};

struct RunRequest
{
    const Pipeline* pipeline = nullptr;
    std::filesystem::path store;
    std::filesystem::path out;
    int cores = 1;
    double memory_mb = 0;      ///< Limits the expected memory of concurrent stages together; 0: no limit.
    int jobs = 1;              ///< Combinations of a matrix that are at work at once.
    bool keep_going = false;   ///< Start further combinations of a matrix after one has failed.
    bool replace = false;      ///< --replace: outputs overwrite files that fresco did not write.
    bool only_stored = false;  ///< Start no stage: results that are in the store are all there will be.
    std::string until;         ///< Empty: everything.
    StageLimits limits;
    std::optional<RunPart> part;  ///< Stages to run in place of all or `until`; others only give their results.
};

struct RunSummary
{
    std::vector<StageOutcome> stages;
    std::vector<Exporter::File> files;
    /// 0 done, 1 a stage failed, 3 an input is missing, 4 a plugin failed, 75 interrupted.
    int exit_code = 0;

    /// nullptr where the run had no such stage.
    const StageOutcome* outcome_of(const std::string& stage) const;

  private:
    mutable std::map<std::string, std::size_t> places_;  ///< In `stages`, once somebody asked.
};

/// Runs a checked pipeline: every stage at most once, each in a process of its own, independent ones side by side within `cores`
/// and `memory_mb` (at least one stage runs; a stage of unknown memory runs alone). A stage that fails stops only what depends on
/// it. SIGINT, SIGTERM and SIGHUP end the run in order. Measurements and records of what a stage led to that cannot be written (a
/// full disk) are noted, and the run goes on. One thread; call once at a time. Throws Error if the store cannot be used.
RunSummary run_pipeline(const RunRequest& request, ProgressDisplay& display);

}  // namespace fresco::host
