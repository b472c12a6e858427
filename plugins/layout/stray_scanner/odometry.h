#pragma once

#include <fresco/camera.h>
#include <fresco/recordings/recorded_view.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace stray_scanner
{

/// A row of odometry.csv.
struct Row
{
    double time_s = 0;
    std::string frame;  ///< "000012": the name of the depth picture and of the confidence.
    /// With OpenCV's camera axes, in ARKit's world, y up; nothing where a number is not finite.
    std::optional<fresco::RigidTransform> world_from_camera{};
    std::optional<fresco::Intrinsics> camera{};  ///< Newer recordings have it for each picture; without a size.
    std::string source{};
};

/// Reads odometry.csv: a line that names the columns timestamp, frame, x, y, z, qx, qy, qz, qw and perhaps fx, fy, cx, cy, in any
/// order and beside others, and a line for each picture of the video. Throws Error "source:line: …" for anything else, and for
/// times that do not grow.
std::vector<Row> parse_odometry(std::string_view text, std::string_view source);

/// Reads camera_matrix.csv, 3x3.
fresco::recordings::CameraMatrix parse_camera_matrix(std::string_view text, std::string_view source);

}  // namespace stray_scanner
