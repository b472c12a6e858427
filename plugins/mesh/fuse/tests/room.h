#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>

/// \file A room that is a box of 3 m x 2 m x 2.4 m (x, y, z from 0), for the tests of fusion.

namespace test_room
{

inline constexpr fresco::Vec3d size{3, 2, 2.4};
inline constexpr fresco::Vec3d middle{1.5, 1, 1.2};

/// In the middle of the room, turned about y.
inline fresco::Camera camera_at(double angle, int width = 160)
{
    return fresco::testing::camera(width, width * 3 / 4, 0.6 * width, middle, angle);
}

/// Along the optical axis to walls, floor and ceiling of this room or one of another size.
inline fresco::RasterF depth_of(const fresco::Camera& camera, fresco::Vec3d size = test_room::size)
{
    const fresco::Vec3d at = camera.world_from_camera.translation;
    fresco::RasterF depth(camera.intrinsics.width, camera.intrinsics.height);
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
        {
            const fresco::Vec3d ray = camera.ray(x + 0.5, y + 0.5);
            const auto wall = [](double from, double along, double far) {
                return along > 0 ? (far - from) / along : along < 0 ? -from / along : 1e9;
            };
            depth.at(x, y) =
                static_cast<float>(std::min({wall(at.x, ray.x, size.x), wall(at.y, ray.y, size.y), wall(at.z, ray.z, size.z)}));
        }
    return depth;
}

inline double distance_to_walls(fresco::Vec3f p)
{
    return std::min({std::abs(double{p.x}), std::abs(p.x - size.x), std::abs(double{p.y}), std::abs(p.y - size.y),
                     std::abs(double{p.z}), std::abs(p.z - size.z)});
}

}  // namespace test_room
