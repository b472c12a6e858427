#pragma once

#include <fresco/splats/splats.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>

/// \file A wall of 1 m x 1 m with soft stripes, and Gaussians on it.

namespace painted_wall
{

using namespace fresco;

inline constexpr double stroke_m = 0.08;  ///< Half a wavelength.

/// The color at a point of the wall, 0 to 1.
inline Vec3d color(double x, double y)
{
    const double wave = std::sin(std::numbers::pi * (x + 0.3 * y) / stroke_m);
    return {0.5 + 0.25 * wave, 0.5 - 0.25 * wave, 0.4 + 0.1 * wave};
}

/// The wall lies at z = 1 and faces the origin.
inline TexturedMesh wall(const std::function<Vec3d(double, double)>& shade = color)
{
    constexpr int size = 256;
    TexturedMesh textured;
    textured.mesh = testing::rectangle({-0.5F, 0.5F, 1}, {1, 0, 0}, {0, -1, 0}, 4, 4);
    testing::set_texcoords(textured.mesh, [](Vec3f p) { return Vec2f{p.x + 0.5F, 0.5F - p.y}; });
    textured.image.pixels = Raster8(size, size, 3);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const Vec3d c = shade((x + 0.5) / size - 0.5, (y + 0.5) / size - 0.5);
            std::size_t channel = 0;
            for (const double each : {c.x, c.y, c.z})
                textured.image.pixels.at(x, y, static_cast<int>(channel++)) = static_cast<std::uint8_t>(std::lround(255 * each));
        }
    return textured;
}

inline void add(splats::Splats& splats, Vec3f center, Vec3f scale, float opacity, std::array<float, 4> rotation = {1, 0, 0, 0})
{
    splats.centers.push_back(center);
    splats.rotations.push_back(rotation);
    splats.scales.push_back(scale);
    splats.opacities.push_back(opacity);
    splats.colors.push_back({0.9F, 0.1F, 0.9F});
}

/// Flat Gaussians all over the wall in a grid, wide enough to hide what is behind it. In a mixed order, as trainers leave them:
/// in the grid's own, each would hide half of the next one, and the picture would be shifted.
inline splats::Splats covering(double spacing, float opacity = 0.98F, double sigma = 0)
{
    const auto scale = static_cast<float>(sigma > 0 ? sigma : 0.7 * spacing);
    const auto side = static_cast<std::size_t>(1 / spacing) + 1;
    constexpr std::size_t prime = 1000003;
    splats::Splats splats;
    for (std::size_t i = 0; i < side * side; ++i)
    {
        const std::size_t at = i * prime % (side * side);
        add(splats,
            {static_cast<float>(static_cast<double>(at % side) * spacing - 0.5),
             static_cast<float>(static_cast<double>(at / side) * spacing - 0.5), 1},
            {scale, scale, 1e-4F}, opacity);
    }
    return splats;
}

}  // namespace painted_wall
