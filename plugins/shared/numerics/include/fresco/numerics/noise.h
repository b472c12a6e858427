#pragma once

#include <cstdint>

/// \file Pseudo-random numbers from integer hashes: pure functions, the same on every machine and for any order of calls. For
/// pictures and geometry, not for statistics or secrets.

namespace fresco::noise
{

/// A bijection of 32 bits in which every bit of `x` changes about half of the result's.
constexpr std::uint32_t hash(std::uint32_t x)
{
    x ^= x >> 16U;
    x *= 0x7feb352dU;
    x ^= x >> 15U;
    x *= 0x846ca68bU;
    x ^= x >> 16U;
    return x;
}

constexpr std::uint32_t hash(std::uint32_t a, std::uint32_t b)
{
    return hash(a * 0x9e3779b9U + hash(b));
}

/// The upper 24 bits of a hash as [0, 1).
constexpr float unit(std::uint32_t h)
{
    return static_cast<float>(h >> 8U) * (1.0f / 16777216.0f);
}

/// [0, 1)
constexpr float unit(std::uint32_t a, std::uint32_t b)
{
    return unit(hash(a, b));
}

/// 0 below `from`, 1 above `to`, with a continuous derivative between.
constexpr float smooth_step(float from, float to, float x)
{
    const float t = (x - from) / (to - from);
    return t <= 0 ? 0.0f : t >= 1 ? 1.0f : t * t * (3 - 2 * t);
}

}  // namespace fresco::noise
