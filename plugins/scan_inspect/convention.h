#pragma once

#include <fresco/camera.h>

#include <string>
#include <vector>

namespace fresco::inspect
{

/// How recorded poses may have been meant: what turns them into world_from_camera with OpenCV axes in the mesh's world and unit.
struct Convention
{
    bool inverted = false;  ///< They are camera_from_world.
    double scale = 1;       ///< Multiplies their translations.
    Mat3 camera_turn;  ///< recorded_from_opencv: the columns are OpenCV's right, down, forward in the recorder's camera axes.
    Mat3 world_turn;   ///< mesh_from_world.

    RigidTransform correct(const RigidTransform& recorded) const;
    friend bool operator==(const Convention&, const Convention&) = default;
};

/// The 24 rotations that take axes to axes; the identity first, then OpenGL's (y and z turned round).
const std::vector<Mat3>& axis_rotations();

/// "+x -y -z": the axes that the columns of an axis rotation are.
std::string axis_names(const Mat3& turn);

/// The conventions that recordings come in, likely ones first, without the one of the SDK: OpenGL axes, inverted poses,
/// translations in millimeters, centimeters, or meters where the mesh is not. `rare`: also every other choice of camera axes, and
/// worlds turned by right angles.
std::vector<Convention> candidate_conventions(bool rare);

/// A factor between units that is within 7 % of `scale` (1000, 0.001, 0.25, …), or `scale` itself.
double usual_scale(double scale);

}  // namespace fresco::inspect
