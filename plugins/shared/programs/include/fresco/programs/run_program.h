#pragma once

#include <fresco/process.h>
#include <fresco/run_context.h>

#include <functional>
#include <limits>
#include <string>

/// \file Runs another program for a stage, to its end: what it prints arrives line by line, and it stops with the stage.

namespace fresco::programs
{

/// Runs a program, gives each line that it prints to `take_line`, and ends whatever it leaves behind. What it started gets
/// SIGTERM when the run is stopped or the program takes longer than `most_seconds`, and SIGKILL 5 s later at most; all of it ends
/// with the host, should that be killed. For a process that waits for no other child. Throws Error if it cannot be started or
/// takes too long; Canceled.
ProcessEnd run_program(const ProcessStart& start, RunContext& run, const std::function<void(const std::string&)>& take_line,
                       double most_seconds = std::numeric_limits<double>::infinity());

}  // namespace fresco::programs
