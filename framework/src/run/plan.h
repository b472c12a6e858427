#pragma once

#include "pipeline/pipeline.h"
#include "run/run_state.h"
#include "store/statistics.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

/// \file Tells what would run, why, and what it took the last times. `fresco plan` prints it.

namespace fresco::host
{

struct PlannedStage
{
    std::string stage;
    std::string type;
    bool runs = false;
    std::string reason{};                         ///< Why it runs, or why it does not.
    std::map<std::string, std::string> chosen{};  ///< See types_by_marks.
    std::optional<Usage> measured{};              ///< Empty before its first run.
    std::size_t files_to_copy = 0;                ///< Files of a stored result that are missing or different below `out`.
};

struct Plan
{
    std::vector<PlannedStage> stages;
    std::vector<std::string> obstacles;  ///< Files for which the run would stop, see Exporter.
    Usage total;                         ///< Sum of the seconds and largest memory of the measured stages that run.
    std::size_t unmeasured_count = 0;    ///< Stages that run for the first time.
};

/// Plans a run with its files below `out`. Changes nothing but remembered file stamps.
Plan make_plan(const Pipeline& pipeline, const std::filesystem::path& store, const std::filesystem::path& out,
               const std::string& until, bool replace = false);

}  // namespace fresco::host
