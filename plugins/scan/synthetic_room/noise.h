#pragma once

#include <fresco/numerics/noise.h>

#include <cstdint>

/// \file Smooth noise for materials: the same on every machine.
namespace room
{

using fresco::noise::hash;
using fresco::noise::smooth_step;
using fresco::noise::unit;

/// Mean 0, variance 1, bounded by +-2 sqrt(3): four uniform numbers summed.
inline float bell(std::uint32_t seed)
{
    float sum = 0;
    for (std::uint32_t i = 0; i < 4; ++i)
        sum += unit(seed, i);
    return (sum - 2.0f) * 1.7320508f;
}

inline std::uint32_t lattice(int x, int y, std::uint32_t seed)
{
    return hash(static_cast<std::uint32_t>(x) * 0x8da6b343U + static_cast<std::uint32_t>(y) * 0xd8163841U + seed);
}

inline float smooth(float t)
{
    return t * t * (3 - 2 * t);
}

/// Mixes numbers or colors.
template <class T>
T mix(T a, T b, float t)
{
    return a + (b - a) * t;
}

/// std::floor without a library call; |x| < 2^31.
inline int whole(float x)
{
    const int truncated = static_cast<int>(x);
    return truncated - (static_cast<float>(truncated) > x ? 1 : 0);
}

/// Smooth noise in [0, 1] with features of size 1.
inline float value_noise(float x, float y, std::uint32_t seed)
{
    const int ix = whole(x), iy = whole(y);
    const float tx = smooth(x - static_cast<float>(ix)), ty = smooth(y - static_cast<float>(iy));
    const float lower = mix(unit(lattice(ix, iy, seed)), unit(lattice(ix + 1, iy, seed)), tx);
    const float upper = mix(unit(lattice(ix, iy + 1, seed)), unit(lattice(ix + 1, iy + 1, seed)), tx);
    return mix(lower, upper, ty);
}

/// Octaves of noise in [0, 1], mean 0.5. Octaves finer than `footprint` (in the same units as x, y) fade out, so that distant
/// surfaces do not flicker.
inline float fractal_noise(float x, float y, int octaves, float footprint, std::uint32_t seed)
{
    float sum = 0, amplitude = 0.5f, frequency = 1, total = 0;
    for (int i = 0; i < octaves; ++i)
    {
        const float keep = 1 - smooth_step(0.3f, 0.9f, footprint * frequency);
        if (keep > 0)
            sum += amplitude * keep * (value_noise(x * frequency, y * frequency, seed + static_cast<std::uint32_t>(i)) - 0.5f);
        total += amplitude;
        amplitude *= 0.55f;
        frequency *= 2.03f;
    }
    return 0.5f + sum / total;
}

}  // namespace room
