#pragma once

#include <fresco/math.h>

namespace fresco::numerics
{

/// The rotation by the vector's length, in radians, about its direction (Rodrigues).
Mat3 rotation_by(Vec3d turn);

/// The rotation of the quaternion w + x i + y j + z k, whose length is 1.
Mat3 rotation_of(double w, double x, double y, double z);

}  // namespace fresco::numerics
