#pragma once

#include "frames_texture.h"

#include <fresco/math.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

/// \file A wall of 2 m x 2 m in the plane z = 0, seen from z < 0; texture u runs along x, v against y. Everything is known by
/// hand, and nothing is rendered by the code under test.

namespace painted_wall
{

using namespace fresco;
using namespace fresco::from_frames;

using Paint = std::function<Vec3f(double u, double v)>;

/// Smooth, so that bilinear lookups cost little.
inline Vec3f smooth_paint(double u, double v)
{
    return {static_cast<float>(0.5 + 0.25 * std::sin(9 * u + 2 * v)), static_cast<float>(0.45 + 0.3 * std::cos(7 * v)),
            static_cast<float>(0.35 + 0.3 * u * v)};
}

/// At (x, y, -distance), turned about the y axis so that it looks at the wall from the side.
inline Camera camera_at(double x, double y, double distance, double turn = 0, int width = 160, int height = 120)
{
    return testing::camera(width, height, 0.8 * width, {x, y, -distance}, turn);
}

/// Five views that see the whole wall, from several sides.
inline std::vector<Camera> five_cameras()
{
    return {camera_at(1, 1, 2.6), camera_at(0.4, 0.9, 2.5, 0.2), camera_at(1.7, 1.1, 2.6, -0.25), camera_at(0.9, 0.7, 2.8, 0.05),
            camera_at(1.2, 1.3, 3.0, -0.1)};
}

struct Point
{
    bool seen = false;
    double u = 0;
    double v = 0;
    double depth = 0;
    double cosine = 0;
};

inline Point point_at(const Camera& camera, double x, double y)
{
    const Vec3d origin = camera.world_from_camera.translation;
    const Vec3d ray = camera.ray(x, y);
    Point point;
    if (!(ray.z > 0))
        return point;
    point.depth = -origin.z / ray.z;
    const Vec3d at = origin + ray * point.depth;
    point.u = at.x / 2;
    point.v = 1 - at.y / 2;
    point.cosine = ray.z / length(ray);
    point.seen = point.u > 0 && point.u < 1 && point.v > 0 && point.v < 1;
    return point;
}

inline UvMap map_of(const Camera& camera, int height)
{
    const int width = camera.intrinsics.width_at(height);
    const Camera own{camera.intrinsics.scaled_to(width, height), camera.world_from_camera};
    UvMap map{RasterF(width, height, 2), RasterF(width, height), RasterF(width, height), Raster8(width, height)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (const Point point = point_at(own, x + 0.5, y + 0.5); point.seen)
            {
                map.uv.at(x, y, 0) = static_cast<float>(point.u);
                map.uv.at(x, y, 1) = static_cast<float>(point.v);
                map.depth.at(x, y) = static_cast<float>(point.depth);
                map.cosine.at(x, y) = static_cast<float>(point.cosine);
                map.valid.at(x, y) = 1;
            }
    return map;
}

/// The camera's picture, the mean of 3 x 3 points a pixel.
inline Raster8 picture_of(const Camera& camera, const Paint& paint, Vec3f gain = {1, 1, 1})
{
    return testing::picture(camera.intrinsics.width, camera.intrinsics.height,
                            [&](int x, int y, int c)
                            {
                                Vec3f sum;
                                for (int i = 0; i < 9; ++i)
                                    if (const Point point = point_at(camera, x + (i % 3 + 0.5) / 3, y + (i / 3 + 0.5) / 3);
                                        point.seen)
                                        sum += paint(point.u, point.v) * (1.0F / 9);
                                return 255 * (&sum.x)[c] * (&gain.x)[c];
                            });
}

inline View view_of(const Camera& camera, int map_height, const Paint& paint, Vec3f gain = {1, 1, 1})
{
    return {map_of(camera, map_height), camera, picture_of(camera, paint, gain), {}, "walk"};
}

inline FramesTexture texture_of(const std::vector<View>& views, const TextureRules& rules, Progress& progress)
{
    return frames_texture(
        views.size(), [&](std::size_t i, bool) { return views[i]; }, rules, progress);
}

/// The largest difference of a channel from the painting, over the texels at least two inside the wall.
inline double largest_error(const FramesTexture& texture, const Paint& paint)
{
    double largest = 0;
    const int size = texture.picture.width;
    for (int y = 2; y < size - 2; ++y)
        for (int x = 2; x < size - 2; ++x)
        {
            const Vec3f truth = paint((x + 0.5) / size, 1 - (y + 0.5) / size);
            for (int c = 0; c < 3; ++c)
                largest = std::max(largest, std::abs(double{texture.picture.at(x, y, c)} - double{(&truth.x)[c]}));
        }
    return largest;
}

}  // namespace painted_wall
