#include <fresco/camera.h>

#include <algorithm>
#include <cmath>

namespace fresco
{

Intrinsics Intrinsics::scaled_to(int new_width, int new_height) const
{
    const double sx = static_cast<double>(new_width) / width;
    const double sy = static_cast<double>(new_height) / height;
    return {new_width, new_height, fx * sx, fy * sy, cx * sx, cy * sy};
}

int Intrinsics::width_at(int new_height) const
{
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(new_height) * width / height)));
}

Vec3d Camera::project(Vec3d world_point) const
{
    const Vec3d p = transposed(world_from_camera.rotation) * (world_point - world_from_camera.translation);
    return {intrinsics.fx * p.x / p.z + intrinsics.cx, intrinsics.fy * p.y / p.z + intrinsics.cy, p.z};
}

Vec3d Camera::ray(double x, double y) const
{
    return world_from_camera.direction({(x - intrinsics.cx) / intrinsics.fx, (y - intrinsics.cy) / intrinsics.fy, 1.0});
}

}  // namespace fresco
