#pragma once

#include "cluster/job_arrays.h"
#include <fresco/process.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

/// \file Slurm: the scripts that it gets, and what its commands answer. `fresco submit slurm`, `status` and `cancel` use it. What
/// makes scripts is pure, and throws Error where there is a script_problem; what asks Slurm needs the host to be single-threaded.

namespace fresco::host
{

/// What all jobs of a folder have in common.
struct SlurmSettings
{
    std::string run{};              ///< "fresco-4f09a2c1": how the names of its jobs begin; no other folder has it.
    std::filesystem::path program;  ///< fresco, absolute.
    std::string partition{};        ///< Empty: the scheduler's default.
    std::string gpu_partition{};    ///< Empty: `partition`.
    std::size_t max_queued = 0;     ///< Elements in the queue at a time; 0: half of what the scheduler allows.
};

/// Arrays that are submitted together, in a folder of their own below the submission's.
struct Wave
{
    std::filesystem::path folder;  ///< The submission's, absolute.
    std::size_t number = 0;
    std::vector<JobArray> arrays;
    bool continued = false;    ///< A job at its end queues what is left.
    std::string follows = {};  ///< Of a wave without arrays: the job whose end makes room for others.
};

/// Why one of them or the submission's folder cannot stand in a script; empty: all can.
std::string script_problem(const SlurmSettings& settings, const std::filesystem::path& folder);

/// "slurm/wave-000", below the submission's folder.
std::filesystem::path wave_folder(std::size_t number);
/// "fresco-4f09a2c1.0.texture-0"
std::string job_name(const SlurmSettings& settings, std::size_t wave, const std::string& array);

/// The batch script of an array: runs the task that the array's list has for its index.
std::string array_script(const SlurmSettings& settings, const Wave& wave, const JobArray& array);
/// The list: a line "INDEX TASK NAME" per element.
std::string array_list(const JobArray& array);
/// The batch script of the job that queues what is left.
std::string continuing_script(const SlurmSettings& settings, const Wave& wave);
/// The script that submits the wave. Run again, it submits nothing twice.
std::string submit_script(const SlurmSettings& settings, const Wave& wave);

struct ProgramEnd
{
    int exit_code = -1;
    std::string output;  ///< Standard output and error together.

    /// The output for a message: a line behind a blank, several each on a line of its own behind a bar.
    std::string quoted_output() const;
};

/// Runs the program that is the first of the arguments, which is looked for in PATH, to its end. Throws MissingInput if it does
/// not exist.
ProgramEnd run_program(ProcessStart start);

/// What a command of Slurm's prints. Throws Error if it fails.
std::string slurm_answer(const std::vector<std::string>& words);

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
