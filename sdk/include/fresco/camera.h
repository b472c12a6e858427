#pragma once

#include <fresco/math.h>

#include <optional>
#include <span>

/// \file Where a picture was taken from: intrinsics and pose, with the conventions that all stages share, and which way is up by
/// many of them.

namespace fresco
{

/// Pinhole intrinsics in pixels. The center of pixel (0,0) is at (0.5, 0.5), so the image spans [0, width] x [0, height].
struct Intrinsics
{
    int width = 0;
    int height = 0;
    double fx = 0;
    double fy = 0;
    double cx = 0;
    double cy = 0;

    /// Scales the camera to another size, each axis on its own.
    Intrinsics scaled_to(int new_width, int new_height) const;
    /// Width that keeps the aspect ratio at `new_height`: round(h * W / H), at least 1.
    int width_at(int new_height) const;
    friend bool operator==(const Intrinsics&, const Intrinsics&) = default;
};

/// A posed pinhole camera with OpenCV axes (x right, y down, z forward), meters.
struct Camera
{
    Intrinsics intrinsics;
    RigidTransform world_from_camera;

    /// Pixel coordinates (x, y) and depth z (meters along the optical axis) of a world point; x, y are meaningless for z <= 0.
    Vec3d project(Vec3d world_point) const;
    /// World direction through pixel coordinates (x, y), scaled so that its z in the camera is 1.
    Vec3d ray(double x, double y) const;
    friend bool operator==(const Camera&, const Camera&) = default;
};

/// Upward direction of cameras (poses world_from_camera, OpenCV axes), unit length: the one that their horizontal axes are most
/// nearly perpendicular to, as recorders are held level however far they look down. Phones held upright store pictures lying on
/// their left side; where the cameras agree better on -x than on -y, that is up. Empty if they are turned every way.
std::optional<Vec3d> cameras_up(std::span<const RigidTransform> poses);

}  // namespace fresco
