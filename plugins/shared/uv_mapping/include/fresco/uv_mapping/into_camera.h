#pragma once

#include <fresco/camera.h>

namespace fresco
{

/// Takes world points into a camera's frame: the inverse of world_from_camera in double precision. A recorded pose is a rotation
/// to a few digits only, and RigidTransform::inverse would lay points up to a pixel's tenth beside the rays that meet them.
class IntoCamera
{
  public:
    /// The pose must have passed check_camera.
    explicit IntoCamera(const RigidTransform& world_from_camera) : origin_(world_from_camera.translation)
    {
        const Mat3& r = world_from_camera.rotation;
        const Vec3d x{r(0, 0), r(1, 0), r(2, 0)};
        const Vec3d y{r(0, 1), r(1, 1), r(2, 1)};
        const Vec3d z{r(0, 2), r(1, 2), r(2, 2)};
        const double one = 1 / dot(x, cross(y, z));
        x_ = cross(y, z) * one;
        y_ = cross(z, x) * one;
        z_ = cross(x, y) * one;
    }

    Vec3d point(Vec3f world) const
    {
        const Vec3d p = vec_cast<double>(world) - origin_;
        return {dot(x_, p), dot(y_, p), dot(z_, p)};
    }
    /// Axis whose product with a world direction is its length along the optical axis.
    Vec3d depth_axis() const { return z_; }

  private:
    Vec3d origin_;
    Vec3d x_;
    Vec3d y_;
    Vec3d z_;
};

}  // namespace fresco
