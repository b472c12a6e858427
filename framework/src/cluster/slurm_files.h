#pragma once

#include "cluster/job_arrays.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

/// \file The texts that Slurm gets. Pure. Those that make scripts throw Error where there is a script_problem.

namespace fresco::host
{

/// What all jobs of a folder have in common.
struct SlurmSettings
{
    std::string run;                ///< "fresco-4f09a2c1": how the names of its jobs begin; no other folder has it.
    std::filesystem::path program;  ///< fresco, absolute.
    std::string partition;          ///< Empty: the scheduler's default.
    std::string gpu_partition;      ///< Empty: `partition`.
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

}  // namespace fresco::host
