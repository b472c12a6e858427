#pragma once

#include <cstdint>

/// \file How bright displayed colors are: the luma of Rec. 601, for whatever compares pictures without their colors.

namespace fresco
{

/// 0..255.
inline double luma(const std::uint8_t* rgb)
{
    return 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
}

/// The same in steps of 2^-15, not rounded yet.
inline int fixed_luma(const std::uint8_t* rgb)
{
    return 9798 * rgb[0] + 19235 * rgb[1] + 3735 * rgb[2];
}

}  // namespace fresco
