#pragma once

#include <sys/types.h>

#include <vector>

namespace fresco
{

/// What a process started itself.
std::vector<pid_t> children_of(pid_t pid);
/// What a process started, and what those started. Of a process that adopts orphans that is all that was ever started by it.
std::vector<pid_t> descendants_of(pid_t pid);
void signal_descendants(pid_t pid, int number);
/// From now on whatever descends from this process stays below it, also when its parent ends.
void adopt_orphans();
/// Kills all that descends from this process and takes their ends: for one that adopts orphans, and waits for no child any more.
void end_descendants();

}  // namespace fresco
