#pragma once

#include <cstdint>

namespace fresco::optimize
{

/// SplitMix64's finaliser (Steele, Lea and Flood, OOPSLA 2014): the same numbers on every machine.
constexpr std::uint64_t mixed(std::uint64_t x)
{
    x += 0x9E3779B97F4A7C15ULL;
    x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
    return x ^ (x >> 31U);
}

/// A number that depends on all three.
constexpr std::uint64_t mixed(std::uint64_t seed, std::uint64_t a, std::uint64_t b)
{
    return mixed(mixed(mixed(seed) ^ a) ^ b);
}

}  // namespace fresco::optimize
