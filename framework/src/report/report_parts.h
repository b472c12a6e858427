#pragma once

#include <string_view>

/// \file The styles and scripts of report.html, built into the program.

namespace fresco::host
{

// Of framework/report/, built in by CMake.
extern const std::string_view report_css;
extern const std::string_view report_js;

}  // namespace fresco::host
