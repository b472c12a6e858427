#pragma once

#include <filesystem>
#include <limits>
#include <string>

namespace fresco::host
{

/// What the control groups of a process leave it. Infinity: no limit.
struct ControlGroupLimits
{
    double memory_mb = std::numeric_limits<double>::infinity();       ///< All that its processes may have together.
    double free_memory_mb = std::numeric_limits<double>::infinity();  ///< What none of them has taken yet.
    double cores = std::numeric_limits<double>::infinity();           ///< Processor time per time.
};

/// The narrowest limits of the group that the process is in and of all groups above it, of the versions 1 and 2, as a scheduler
/// sets them for a job. `proc`: of the process ("/proc/self": cgroup and mountinfo). `root` goes before the mount points. What
/// cannot be read limits nothing.
ControlGroupLimits control_group_limits(const std::filesystem::path& proc = "/proc/self",
                                        const std::filesystem::path& root = "/");

}  // namespace fresco::host
