#pragma once

#include <fresco/recordings/recorded_view.h>
#include <fresco/run_context.h>

#include <filesystem>
#include <vector>

namespace seven_scenes
{

/// How the two cameras of a recording see and where they are to each other.
struct Calibration
{
    fresco::recordings::CameraMatrix color;
    fresco::recordings::CameraMatrix depth;
    fresco::RigidTransform color_from_depth;
};

/// What the pipeline gives in place of files; empty lists: not given.
struct CalibrationOptions
{
    std::vector<double> color_intrinsics;  ///< fx, fy, cx, cy
    std::vector<double> depth_intrinsics;  ///< fx, fy, cx, cy
    std::vector<double> color_from_depth;  ///< 16 numbers, row by row
};

/// Each of the three parts from the options, else from its file in `path` (color-intrinsics.txt, depth-intrinsics.txt,
/// color_from_depth.txt), else the values that the makers of 7-Scenes name: focal length 585 and center (320, 240) at 640x480 for
/// both, and one place for both cameras; then a warning says so. Throws Error naming the option or the file and line.
Calibration read_calibration(const std::filesystem::path& path, const CalibrationOptions& options, fresco::RunContext& run);

/// Intrinsics for pictures of this size, such as `picture`. Throws Error if the matrix was assumed and the size is not the one it
/// is for, and as fresco::recordings::intrinsics_for does.
fresco::Intrinsics calibrated(const fresco::recordings::CameraMatrix& matrix, fresco::recordings::PixelCenter center,
                              const fresco::ImageHeader& size, const std::filesystem::path& picture);

}  // namespace seven_scenes
