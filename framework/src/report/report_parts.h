#pragma once

#include <string_view>

namespace fresco::host
{

// Of framework/report/ and of three.js, built in by CMake.
extern const std::string_view report_css;
extern const std::string_view report_js;
/// three.js with its OrbitControls; empty where it was not found when fresco was built.
extern const std::string_view report_three_js;

}  // namespace fresco::host
