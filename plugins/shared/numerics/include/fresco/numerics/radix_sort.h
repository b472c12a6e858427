#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace fresco::numerics
{

/// Sorts by the upper 32 bits, keeping the order of equal ones, in linear time; no upper half exceeds `largest`.
void sort_by_upper_half(std::vector<std::uint64_t>& entries, std::uint32_t largest);

/// A number that is larger for a larger `value`; NaN is above or below all others.
inline std::uint32_t ordered_key(float value)
{
    const auto bits = std::bit_cast<std::uint32_t>(value);
    return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

}  // namespace fresco::numerics
