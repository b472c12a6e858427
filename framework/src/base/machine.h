#pragma once

#include <fresco/value.h>

#include <cstdint>
#include <string>
#include <sys/types.h>

namespace fresco::host
{

/// Of the first processor: model and the instruction sets that numerical libraries choose their kernels by, as a map
/// {model, features}. Results are equal to the byte between machines where `features` agree.
Value processor_capability();

/// Where a stage with these options computes, as a map {features, gpus}: unfinished work is gone on with only where both are the
/// same. `gpus`: models of the NVIDIA GPUs, where the stage has an option "device" that is not "cpu".
Value computing_place(const Value& options);

/// Cores this process may use: those that it may run on, as far as its control groups allow them to be busy.
int available_cores();
/// Memory that programs can have now without others being swapped out, as far as this process's control group allows it; 0 where
/// the system does not tell.
double available_memory_mb();

/// Largest resident memory of this process so far, in MB.
double peak_memory_mb();
/// The same of the largest among the programs that this process started and that have ended.
double peak_memory_of_programs_mb();
/// Resident memory, in MB, of a process and all that descend from it: the sum, what several share counts in each. 0 once it is
/// gone.
double memory_of_tree_mb(pid_t pid);
/// What this machine has, in MB, or the narrowest of the control groups that the process is in.
double machine_memory_mb();
/// Whether the driver finds an NVIDIA GPU that this process may use. Asks once.
bool machine_has_gpu();

/// How many processes this system has killed because memory ran out; 0 where it does not tell.
std::int64_t oom_kills();
/// How many more files this process may open.
int free_descriptors();
/// What this process may map for writing, in MB; 0: no limit.
double memory_limit_mb();

/// Version of this program: "0.1.0".
std::string program_version();

}  // namespace fresco::host
