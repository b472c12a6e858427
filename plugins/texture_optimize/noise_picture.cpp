#include "noise_picture.h"

#include <fresco/numerics/noise.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fresco::optimize
{
namespace
{

constexpr std::uint32_t first_octave = 2;
constexpr std::uint32_t octaves = 5;

/// In [0,1]; the mean is 1/2.
float corner(std::uint32_t x, std::uint32_t y, std::uint32_t key)
{
    return noise::unit(noise::hash(x, y), key);
}

float octave(std::uint32_t x, std::uint32_t y, std::uint32_t shift, std::uint32_t key)
{
    const auto cell = static_cast<float>(1U << shift);
    const std::uint32_t left = x >> shift;
    const std::uint32_t top = y >> shift;
    const float u = (static_cast<float>(x - (left << shift)) + 0.5F) / cell;
    const float v = (static_cast<float>(y - (top << shift)) + 0.5F) / cell;
    const float upper = (1 - u) * corner(left, top, key) + u * corner(left + 1, top, key);
    const float lower = (1 - u) * corner(left, top + 1, key) + u * corner(left + 1, top + 1, key);
    return (1 - v) * upper + v * lower;
}

}  // namespace

RasterF noise_picture(int size_px, Vec3d mean, Vec3d deviation, std::uint64_t seed, int threads)
{
    // A corner's variance is 1/12; between corners, over a cell, 4/9 of it is left.
    const double one = std::sqrt(octaves * (1.0 / 12) * (4.0 / 9));
    const std::array<double, 3> means{mean.x, mean.y, mean.z};
    const std::array<double, 3> deviations{deviation.x / one, deviation.y / one, deviation.z / one};
    const auto size = static_cast<std::size_t>(size_px);
    const auto key = static_cast<std::uint32_t>(seed ^ (seed >> 32U));
    RasterF picture(size_px, size_px, 3);
    parallel_for(size, 64, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t y = begin; y < end; ++y)
                         for (std::size_t i = 0; i < 3 * size; ++i)
                         {
                             const auto channel = static_cast<std::uint32_t>(i % 3);
                             double sum = -0.5 * octaves;
                             for (std::uint32_t o = 0; o < octaves; ++o)
                                 sum +=
                                     static_cast<double>(octave(static_cast<std::uint32_t>(i / 3), static_cast<std::uint32_t>(y),
                                                                first_octave + o, noise::hash(key, 8 * o + channel)));
                             picture.values[y * 3 * size + i] =
                                 static_cast<float>(std::clamp(means[channel] + deviations[channel] * sum, 0.0, 1.0));
                         }
                 });
    return picture;
}

}  // namespace fresco::optimize
