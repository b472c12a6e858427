#pragma once

#include <fresco/process.h>
#include <fresco/run_context.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace fresco::command
{

using TakeLine = std::function<void(const std::string& line)>;

/// Runs a program in `folder` to its end, gives each line that it prints to `take_line`, and ends whatever it leaves behind. What
/// it started gets SIGTERM when the run is stopped, and SIGKILL 5 s later at most; all of it ends with the host, should that be
/// killed. For a process that waits for no other child. Throws Error if there is no such program, and Canceled.
ProcessEnd run_program(const std::vector<std::string>& words, const EnvironmentChanges& environment,
                       const std::filesystem::path& folder, RunContext& run, const TakeLine& take_line);

}  // namespace fresco::command
