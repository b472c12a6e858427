#pragma once

#include <string_view>

namespace fresco::host
{

// Of framework/report/, built in by CMake.
extern const std::string_view report_css;
extern const std::string_view report_js;

}  // namespace fresco::host
