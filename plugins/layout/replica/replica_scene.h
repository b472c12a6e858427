#pragma once

#include <fresco/camera.h>

#include <string_view>
#include <vector>

namespace replica
{

struct SceneCamera
{
    fresco::Intrinsics intrinsics;
    double depth_unit_m = 0;
};

/// The camera of cam_params.json: {"camera": {w, h, fx, fy, cx, cy, scale}}; the first pixel's center is at (0, 0) there, `scale`
/// is steps of depth per meter. Throws Error naming `source`, the key or byte.
SceneCamera parse_camera(std::string_view text, std::string_view source);

/// The poses of traj.txt: world_from_camera with OpenCV axes, 16 numbers row by row on each line. Throws Error "source:line: …",
/// also for a file that is cut.
std::vector<fresco::RigidTransform> parse_trajectory(std::string_view text, std::string_view source);

}  // namespace replica
