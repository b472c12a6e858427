#pragma once

#include <fresco/random.h>

#include <cstdint>

namespace fresco::optimize
{

/// A number that depends on all of `x`: the first one drawn with it as the seed.
inline std::uint64_t mixed(std::uint64_t x)
{
    return Random(x).bits();
}

/// A number that depends on all three.
inline std::uint64_t mixed(std::uint64_t seed, std::uint64_t a, std::uint64_t b)
{
    return mixed(mixed(mixed(seed) ^ a) ^ b);
}

}  // namespace fresco::optimize
