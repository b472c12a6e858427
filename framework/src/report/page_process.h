#pragma once

#include "base/process.h"

#include <chrono>
#include <string>

/// \file The process that makes a page: it shows values of plugins, which may crash or hang.

namespace fresco::host
{

/// In a process that makes a page: says what comes next ("frames of stage scan").
void tell_shown(const std::string& artifact);

/// Waits for the end of such a process. Kills it, with all that it started, where one artifact takes longer than `limit`. What
/// went wrong, with the artifact that was being shown; empty: nothing.
std::string wait_for_page(const Child& child, std::chrono::milliseconds limit);

}  // namespace fresco::host
