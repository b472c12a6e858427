#include "scene.h"

#include <algorithm>
#include <cmath>

namespace bench
{
namespace
{

constexpr double camera_height_m = 1.4;
constexpr double wall_distance_m = 3;
constexpr double field_of_view = 1.2;  ///< Of the height: twice the tangent of half the angle.
constexpr double texture_m = 12;       ///< One unit of uv.

template <class Color>
fresco::RasterF painted(int width, int height, Color color)
{
    fresco::RasterF picture(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const fresco::Vec3d rgb = color((x + 0.5) / height, (y + 0.5) / height);
            const auto clamped = [](double value) { return static_cast<float>(std::clamp(value, 0.0, 1.0)); };
            picture.at(x, y, 0) = clamped(rgb.x);
            picture.at(x, y, 1) = clamped(rgb.y);
            picture.at(x, y, 2) = clamped(rgb.z);
        }
    return picture;
}

}  // namespace

fresco::UvMap generated_view(int height_px)
{
    const int width = height_px * 4 / 3;
    fresco::UvMap map{fresco::RasterF(width, height_px, 2), fresco::RasterF(width, height_px), fresco::RasterF(width, height_px),
                      fresco::Raster8(width, height_px)};
    for (int y = 0; y < height_px; ++y)
        for (int x = 1; x + 1 < width; ++x)
        {
            const double right = (x + 0.5 - width / 2.0) / height_px * field_of_view;
            const double down = ((y + 0.5) / height_px - 0.5) * field_of_view;
            const double to_floor = down > 0 ? camera_height_m / down : 1e9;
            const bool floor = to_floor < wall_distance_m;
            const double depth = floor ? to_floor : wall_distance_m;
            const double across = right * depth / texture_m;
            map.uv.at(x, y, 0) = static_cast<float>((floor ? 0.3 : 0.7) + across);
            map.uv.at(x, y, 1) = static_cast<float>(floor ? depth / texture_m : 0.6 - down * depth / texture_m);
            map.depth.at(x, y) = static_cast<float>(depth);
            const double slant = std::sqrt(1 + right * right + down * down);
            map.cosine.at(x, y) = static_cast<float>((floor ? down : 1) / slant);
            map.valid.at(x, y) = 1;
        }
    return map;
}

fresco::RasterF generated_camera_picture(int width, int height)
{
    return painted(width, height,
                   [](double x, double y)
                   {
                       const double edge = std::sin(9 * x + 4 * std::sin(5 * y)) > 0 ? 0.3 : 0;
                       return fresco::Vec3d{0.3 + 0.3 * y + edge, 0.5 - 0.2 * x + edge * 0.5, 0.25 + 0.2 * std::sin(17 * x * y)};
                   });
}

fresco::RasterF generated_style(int width, int height)
{
    return painted(width, height,
                   [](double x, double y)
                   {
                       const double first = std::sin(60 * x + 8 * std::sin(7 * y));
                       const double second = std::sin(45 * y + 6 * std::sin(9 * x));
                       return first > second ? fresco::Vec3d{0.8, 0.5 + 0.2 * first, 0.1}
                                             : fresco::Vec3d{0.1 + 0.1 * second, 0.2, 0.6 + 0.3 * second};
                   });
}

}  // namespace bench
