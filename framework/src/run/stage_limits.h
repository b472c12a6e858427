#pragma once

#include "pipeline/pipeline.h"

#include <map>
#include <string>
#include <string_view>
#include <vector>

/// \file Limits of isolated stages (--isolate), as people write them, and what a stage gets without words.

namespace fresco::host
{

/// Limits of a stage's process with all that it starts. 0: no limit.
struct StageLimits
{
    double memory_mb = 0;  ///< Resident, all processes together; and what each of them maps for writing.
    double seconds = 0;    ///< From the moment the stage begins.
};

/// "4G", "1.5 GB", "500M", "800000K", in powers of 1024; MB. Throws Error saying what is accepted.
double parse_memory_mb(std::string_view text);
/// "90", "90s", "10m", "1h30m"; seconds. Throws Error saying what is accepted.
double parse_seconds(std::string_view text);

/// As `run --isolate…` gives them.
struct IsolationRequest
{
    std::vector<std::string> stages;  ///< Names (of a matrix: of all its combinations or of one), or "all".
    std::vector<std::string> memory;  ///< "4G" for all of them, "STAGE=4G" for one; the latter goes before.
    std::vector<std::string> seconds;
};

/// The limits of every isolated stage. Where no memory is given it is 90 % of the machine's; where no time is given, ten times
/// `measured_seconds` (by stage, with the same options), at least ten minutes, and an hour where it was not measured. Throws
/// Error for a stage that there is not, with the nearest name, and for a limit of a stage that is not isolated.
std::map<std::string, StageLimits> stage_limits(const IsolationRequest& request, const Pipeline& pipeline,
                                                const std::map<std::string, double>& measured_seconds);

}  // namespace fresco::host
