#pragma once

#include <cstddef>
#include <fresco/process.h>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// \file What Slurm's commands answer. The host must be single-threaded.

namespace fresco::host
{

struct ProgramEnd
{
    int exit_code = -1;
    std::string output;  ///< Standard output and error together.

    /// The output for a message: a line behind a blank, several each on a line of its own behind a bar.
    std::string quoted_output() const;
};

struct ProgramStart
{
    std::vector<std::string> words;  ///< The first is looked for in PATH.
    std::string folder{};
    EnvironmentChanges environment{};
    int channel = -1;  ///< See ProcessStart.
};

/// Runs a program to its end. Throws MissingInput if it does not exist.
ProgramEnd run_program(const ProgramStart& start);

/// What the scheduler accepts.
struct SlurmLimits
{
    std::size_t array_size = 1001;  ///< One more than the largest index of an element.
    std::size_t job_count = 10000;
};
/// Of `scontrol show config`. Throws Error if the scheduler does not answer.
SlurmLimits slurm_limits();
/// The same of its text; what is missing in it has Slurm's default.
SlurmLimits limits_in(const std::string& config);

using ElementId = std::pair<std::string, std::size_t>;  ///< The array's job id and the index.

struct SlurmQueue
{
    std::map<ElementId, std::string> elements;  ///< Their states: "PENDING", "RUNNING", …
    std::map<std::string, std::string> jobs;    ///< Ids by name.
};
/// This user's jobs whose names begin with `run`, those that have ended lately excluded. Throws Error if the scheduler does not
/// answer.
SlurmQueue slurm_queue(const std::string& run);
/// The same of squeue's lines "ID INDEX STATE NAME".
SlurmQueue queue_in(const std::string& lines, const std::string& run);

}  // namespace fresco::host
