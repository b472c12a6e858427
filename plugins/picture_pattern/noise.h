#pragma once

#include <fresco/numerics/noise.h>

#include <cmath>
#include <cstdint>

/// \file Smooth noise: the same on every machine.
namespace pattern
{

using fresco::noise::hash;
using fresco::noise::smooth_step;
using fresco::noise::unit;

/// [-1, 1)
constexpr float signed_unit(std::uint32_t a, std::uint32_t b)
{
    return 2 * unit(a, b) - 1;
}

/// Smooth noise in [0, 1] with features of size 1.
inline float value_noise(float x, float y, std::uint32_t seed)
{
    const float fx = std::floor(x), fy = std::floor(y);
    const auto corner = [&](float cx, float cy)
    {
        return unit(static_cast<std::uint32_t>(static_cast<int>(cx)) * 0x8da6b343U +
                        static_cast<std::uint32_t>(static_cast<int>(cy)) * 0xd8163841U,
                    seed);
    };
    const float tx = smooth_step(0, 1, x - fx), ty = smooth_step(0, 1, y - fy);
    const float lower = corner(fx, fy) * (1 - tx) + corner(fx + 1, fy) * tx;
    const float upper = corner(fx, fy + 1) * (1 - tx) + corner(fx + 1, fy + 1) * tx;
    return lower * (1 - ty) + upper * ty;
}

/// Four octaves, [0, 1].
inline float fractal_noise(float x, float y, std::uint32_t seed)
{
    float sum = 0, amplitude = 0.5f;
    for (std::uint32_t octave = 0; octave < 4; ++octave)
    {
        sum += amplitude * value_noise(x, y, seed + octave);
        x *= 2.03f;
        y *= 2.03f;
        amplitude *= 0.5f;
    }
    return sum / 0.9375f;
}

}  // namespace pattern
