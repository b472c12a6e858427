#pragma once

#include <fresco/value.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <sys/types.h>

/// \file What this machine offers a run: processor, memory and cores, also where a container or a job of a cluster limits
/// them.

namespace fresco::host
{

/// Resources that its control groups leave a process. Infinity: no limit.
struct ControlGroupLimits
{
    double free_memory_mb = std::numeric_limits<double>::infinity();  ///< Memory that none of them uses yet.
    double cores = std::numeric_limits<double>::infinity();           ///< Processor time per time.
};

/// The narrowest limits of the group that the process is in and of all groups above it, of the versions 1 and 2, as a scheduler
/// sets them for a job, where they lie as usual: below /sys/fs/cgroup. `proc`: of the process ("/proc/self"). `root` goes before
/// /sys. What cannot be read limits nothing.
ControlGroupLimits control_group_limits(const std::filesystem::path& proc = "/proc/self",
                                        const std::filesystem::path& root = "/");

/// Model of the first processor and the instruction sets that numerical libraries choose their kernels by, as a map
/// {model, features}. Results are equal to the byte between machines where `features` agree.
Value processor_capability();

/// Hardware that a stage uses, as a map {features, gpus}: unfinished work is resumed only where both are the same. `gpus`: models
/// of the NVIDIA GPUs, if the stage works on one.
Value computing_place(bool on_gpu);

/// Cores this process may use: those that it may run on, as far as its control groups allow them to be busy.
int available_cores();
/// Memory that programs can have now without others being swapped out, as far as this process's control group allows it; 0 where
/// the system does not tell.
double available_memory_mb();

/// Largest resident memory of this process so far, in MB.
double peak_memory_mb();
/// Peak memory of the largest ended program that this process started.
double peak_memory_of_programs_mb();
/// Resident memory, in MB, of a process and all that descend from it: the sum, what several share counts in each. 0 once it is
/// gone.
double memory_of_tree_mb(pid_t pid);
/// Whether the driver finds an NVIDIA GPU that this process may use. Asks once.
bool machine_has_gpu();

/// How many processes this system has killed because memory ran out; 0 where it does not tell.
std::int64_t oom_kills();

/// Version of this program: "0.1.0".
std::string program_version();

}  // namespace fresco::host
