#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/numerics/numerics.h>
#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <vector>

/// \file Two painted walls that meet in the line x = 0, z = 2: x > 0 on z = 2 - 0.8 x, x < 0 on z = 2 + 0.8 x (they come toward
/// the cameras on both sides). Everything is known by hand.

namespace painted_corner
{

using namespace fresco;

inline double wall_z(double x)
{
    return 2 - 0.8 * std::abs(x);
}

/// Brightness in (0, 1): waves of several lengths along the wall and up it.
inline double paint(double x, double y)
{
    return 0.45 + 0.12 * std::sin(9 * x + 2 * y) + 0.1 * std::cos(13 * y - 3 * x) + 0.08 * std::sin(31 * x) * std::cos(27 * y) +
           0.08 * std::sin(4 * x * y + 1);
}

/// Pixel coordinates to the wall: depth along the optical axis. The cameras stand on the open side.
inline double depth_at(const Camera& camera, double x, double y, Vec3d& point)
{
    const Vec3d origin = camera.world_from_camera.translation;
    const Vec3d ray = camera.ray(x, y);
    double nearest = 1e9;
    for (const double side : {1.0, -1.0})  // z = 2 - 0.8 side x
    {
        const double t = (2 - 0.8 * side * origin.x - origin.z) / (ray.z + 0.8 * side * ray.x);
        if (t > 0 && side * (origin.x + t * ray.x) >= 0)
            nearest = std::min(nearest, t);
    }
    point = origin + ray * nearest;
    return nearest;
}

inline Camera camera_at(double x, double y, double z, double turn, int width = 320, int height = 240)
{
    return testing::camera(width, height, 0.9 * width, {x, y, z}, turn);
}

inline std::vector<Camera> cameras()
{
    return {camera_at(0, 0, 0, 0),           camera_at(0.2, 0.1, 0.1, 0.1),
            camera_at(-0.2, 0, 0.1, -0.1),   camera_at(0.1, -0.2, -0.1, 0.02),
            camera_at(-0.1, 0.2, 0, 0.05),   camera_at(0.3, 0, 0, -0.08),
            camera_at(-0.3, 0.1, 0.05, 0.08)};
}

inline Raster8 picture_of(const Camera& camera, double gain = 1)
{
    const auto value = [&](int x, int y, int)
    {
        Vec3d point;
        depth_at(camera, x + 0.5, y + 0.5, point);
        return 255 * gain * paint(point.x, point.y);
    };
    return testing::picture(camera.intrinsics.width, camera.intrinsics.height, value);
}

inline RasterF depth_of(const Camera& camera)
{
    RasterF depth(camera.intrinsics.width, camera.intrinsics.height);
    for (int y = 0; y < depth.height; ++y)
        for (int x = 0; x < depth.width; ++x)
        {
            Vec3d point;
            depth.at(x, y) = static_cast<float>(depth_at(camera, x + 0.5, y + 0.5, point));
        }
    return depth;
}

/// The walls from -1.2 to 1.2 along x and y, in squares of `step` meters, facing the cameras.
inline Mesh mesh_of(double step)
{
    const auto count = static_cast<std::uint32_t>(std::lround(2.4 / step));
    Mesh mesh = testing::rectangle({-1.2F, -1.2F, 0}, {0, 2.4F, 0}, {2.4F, 0, 0}, count, count);
    for (Vec3f& p : mesh.positions)
        p.z = static_cast<float>(wall_z(double{p.x}));
    return mesh;
}

/// The camera as recorded with an error: a rotation about (0.3, 1, 0.2) and a shift.
inline Camera mistaken(const Camera& camera, double turn, Vec3d shift)
{
    const RigidTransform error{numerics::rotation_by(normalized(Vec3d{0.3, 1, 0.2}) * turn), shift};
    return {camera.intrinsics, camera.world_from_camera * error};
}

/// By how many pixels the two cameras see points of the walls apart, root mean square over a grid of `camera`'s picture.
inline double apart_px(const Camera& camera, const Camera& other)
{
    double sum = 0;
    int count = 0;
    for (int y = 20; y < camera.intrinsics.height; y += 40)
        for (int x = 20; x < camera.intrinsics.width; x += 40)
        {
            Vec3d point;
            depth_at(camera, x, y, point);
            const Vec3d seen = other.project(point);
            sum += (seen.x - x) * (seen.x - x) + (seen.y - y) * (seen.y - y);
            ++count;
        }
    return std::sqrt(sum / count);
}

}  // namespace painted_corner
