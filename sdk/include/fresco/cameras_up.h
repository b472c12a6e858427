#pragma once

#include <fresco/math.h>

#include <optional>
#include <span>

namespace fresco
{

/// Which way is up by cameras (poses world_from_camera, OpenCV axes), unit length: what their horizontal axes are most nearly
/// perpendicular to, as recorders are held level however far they look down. Phones held upright store pictures lying on their
/// left side; where the cameras agree better on -x than on -y, that is up. Nothing where they are turned every way.
std::optional<Vec3d> cameras_up(std::span<const RigidTransform> poses);

}  // namespace fresco
