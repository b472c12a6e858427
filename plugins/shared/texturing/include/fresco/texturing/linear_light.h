#pragma once

#include <cstdint>

namespace fresco::texturing
{

/// Linear light in [0,1] of an 8-bit sRGB step (IEC 61966-2-1).
double to_linear(std::uint8_t step);
/// The sRGB step nearest to a linear light, by the curve's value; beyond [0,1] the first or last.
std::uint8_t from_linear(double light);
/// The sRGB value of a linear light, both in [0,1]; beyond them the nearest.
double displayed(double light);

}  // namespace fresco::texturing
