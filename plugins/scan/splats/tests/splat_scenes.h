#pragma once

#include "splat_samples.h"

#include <fresco/numerics/numerics.h>

#include <cmath>

/// \file Splats of flat Gaussians on surfaces that are known.

namespace splat_scenes
{

using namespace fresco;
using splats::Splats;

/// A flat Gaussian across `normal`, of unit length.
inline void add(Splats& splats, Vec3d center, Vec3d normal, double size, double opacity = 0.9, Vec3f color = {0.5F, 0.4F, 0.3F})
{
    splats::samples::add_flat(splats, center, normal, size, size / 20, opacity, color);
}

/// The parallelogram at `corner`, with Gaussians every `step`.
inline void rectangle(Splats& splats, Vec3d corner, Vec3d along, Vec3d across, double step)
{
    const auto count = [&](Vec3d side) { return static_cast<int>(std::round(length(side) / step)); };
    for (int i = 0; i < count(along); ++i)
        for (int k = 0; k < count(across); ++k)
            add(splats, corner + along * ((i + 0.5) / count(along)) + across * ((k + 0.5) / count(across)),
                normalized(cross(along, across)), 0.6 * step);
}

/// z up; of its six sides the top can be left out.
inline void box(Splats& splats, Vec3d low, Vec3d size, double step, bool with_top = true)
{
    const Vec3d x{size.x, 0, 0}, y{0, size.y, 0}, z{0, 0, size.z};
    rectangle(splats, low, x, y, step);
    rectangle(splats, low, x, z, step);
    rectangle(splats, low, y, z, step);
    rectangle(splats, low + y, x, z, step);
    rectangle(splats, low + x, y, z, step);
    if (with_top)
        rectangle(splats, low + z, x, y, step);
}

/// 4 m x 3 m x 2.5 m, with a table and a cupboard.
inline Splats room(bool with_ceiling = true)
{
    Splats splats;
    box(splats, {0, 0, 0}, {4, 3, 2.5}, 0.08, with_ceiling);
    box(splats, {1.5, 1, 0.65}, {1.2, 0.8, 0.1}, 0.05);
    box(splats, {3.2, 0.3, 0.1}, {0.6, 1, 1.8}, 0.06);
    return splats;
}

/// A ball of 10 cm on a pole, over a disk of 30 cm, z up.
inline Splats statue()
{
    Splats splats;
    for (const Vec3d out : numerics::spread_directions(4000))
    {
        const Vec3d beside = normalized(Vec3d{out.x, out.y, 0});
        add(splats, Vec3d{0, 0, 0.3} + out * 0.1, out, 0.004);
        add(splats, beside * (0.3 * std::sqrt((1 - out.z) / 2)), {0, 0, 1}, 0.006);
    }
    box(splats, {-0.02, -0.02, 0}, {0.04, 0.04, 0.2}, 0.006);
    return splats;
}

}  // namespace splat_scenes
