#pragma once

#include <fresco/testing_scenes.h>

#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/random.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

/// \file Pictures and source maps that are known by hand.

namespace samples
{

using namespace fresco;

/// Detail of `cells` pixels, finer parts weaker, as in paintings: RGB.
inline Raster8 detailed_picture(int width, int height, const std::vector<int>& cells = {2, 4, 8, 16})
{
    Random random(7);
    RasterF sum(width, height, 3, 128);
    for (const int cell : cells)
    {
        RasterF coarse(width / cell, height / cell, 3);
        for (float& v : coarse.values)
            v = static_cast<float>(3 * cell * random.normal());
        const RasterF fine = resized(coarse, width, height);
        std::transform(sum.values.begin(), sum.values.end(), fine.values.begin(), sum.values.begin(), std::plus<>());
    }
    Raster8 result(width, height, 3);
    std::transform(sum.values.begin(), sum.values.end(), result.values.begin(),
                   [](float v) { return static_cast<std::uint8_t>(std::clamp(v + 0.5F, 0.0F, 255.0F)); });
    return result;
}

/// A map with no texel, for the wall of two charts.
inline SourceMap empty_map(const Mesh& mesh, int size_px, const Raster8& picture, double pixels_per_texel)
{
    SourceMap map;
    map.atlas = atlas_id(mesh);
    map.picture_width = picture.width;
    map.picture_height = picture.height;
    map.pixels_per_texel = static_cast<float>(pixels_per_texel);
    map.places = Raster16(size_px, size_px, 3, SourceMap::none);
    return map;
}

/// Calls set(x, y) for each texel of a map that touches a chart of the wall of two charts.
inline void for_each_wall_texel(int size_px, const std::function<void(int, int)>& set)
{
    const auto touches = [size_px](int i, double from)
    { return (i + 1.0) / size_px > from && static_cast<double>(i) / size_px < from + 0.3; };
    for (int y = 0; y < size_px; ++y)
        for (int x = 0; x < size_px; ++x)
            if (touches(size_px - 1 - y, 0.1) && (touches(x, 0.1) || touches(x, 0.6)))
                set(x, y);
}

/// Squares of `side` x `side` texels, each copied from another place in the picture at another angle.
inline SourceMap patched_map(const Mesh& mesh, int size_px, const Raster8& picture, double pixels_per_texel, int side = 4)
{
    SourceMap map = empty_map(mesh, size_px, picture, pixels_per_texel);
    for_each_wall_texel(size_px,
                        [&](int x, int y)
                        {
                            Random random(static_cast<std::uint64_t>((y / side) * size_px + x / side));
                            const double margin = 0.75 * side * pixels_per_texel;
                            const double from_x = margin + random.uniform() * (picture.width - 2 * margin);
                            const double from_y = margin + random.uniform() * (picture.height - 2 * margin);
                            const double angle = 2 * std::numbers::pi * random.uniform();
                            const double dx = (x % side - (side - 1) / 2.0) * pixels_per_texel;
                            const double dy = (y % side - (side - 1) / 2.0) * pixels_per_texel;
                            map.set_place(x, y,
                                          {{static_cast<float>(from_x + std::cos(angle) * dx - std::sin(angle) * dy),
                                            static_cast<float>(from_y + std::sin(angle) * dx + std::cos(angle) * dy)},
                                           static_cast<float>(angle)});
                        });
    return map;
}

}  // namespace samples
