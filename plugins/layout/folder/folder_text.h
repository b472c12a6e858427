#pragma once

#include <fresco/math.h>
#include <fresco/recordings/recorded_view.h>

#include <string>
#include <string_view>
#include <vector>

namespace folder
{

/// How the poses of a folder are to be read.
struct PoseConvention
{
    bool opengl = false;             ///< Camera axes x right, y up, z backward; else OpenCV's: x right, y down, z forward.
    bool camera_from_world = false;  ///< Else world_from_camera.
};

/// A 3x3 matrix of intrinsics, or in one line fx, fy, cx, cy or the word "equirectangular": 360° pictures, without values. Throws
/// Error naming `source` and line, also for one line that does not end.
fresco::recordings::CameraMatrix parse_intrinsics(std::string_view text, const std::string& source);

struct ListedPose
{
    std::vector<double> matrix;  ///< Row-major 4x4.
    std::string source;          ///< "poses.txt:3".
};

/// A pose per line: the 12 or 16 numbers of a 3x4 or 4x4 matrix, row by row; lines that begin with '#' are skipped. Throws Error
/// naming `source` and line, also for a text that does not end in a line's end.
std::vector<ListedPose> parse_poses(std::string_view text, std::string_view source);
/// The one pose of a text: 3 or 4 rows of 4 numbers. Throws Error naming `source` and line, also for 3 rows that do not end in a
/// line's end.
std::vector<double> parse_pose(std::string_view text, std::string_view source);

/// world_from_camera with OpenCV's axes. Throws Error naming `source` unless the matrix is a rigid transform.
fresco::RigidTransform pose_of(const std::vector<double>& matrix, const PoseConvention& convention, const std::string& source);

}  // namespace folder
