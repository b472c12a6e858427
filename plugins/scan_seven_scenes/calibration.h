#pragma once

#include <fresco/matrix_text.h>

#include <filesystem>
#include <string>
#include <vector>

/// How the two cameras of a recording see and where they are to each other.
struct Calibration
{
    /// Row-major 3x3, in pixels, as the recorder counts them; with the text that names where they are from.
    std::vector<double> color_matrix;
    std::vector<double> depth_matrix;
    std::string color_source;
    std::string depth_source;
    fresco::RigidTransform color_from_depth;
    fresco::PixelCenter center = fresco::PixelCenter::half;
    std::vector<std::filesystem::path> files;  ///< The files it was read from.
    std::vector<std::string> missing;  ///< Names of files in the scan's folder that it would be read from, were they there.
    std::vector<std::string> guesses;  ///< What had to be assumed, as sentences for the user.
};

/// What the pipeline gives in place of files; empty lists: not given.
struct CalibrationOptions
{
    std::vector<double> color_intrinsics;  ///< fx, fy, cx, cy
    std::vector<double> depth_intrinsics;  ///< fx, fy, cx, cy
    std::vector<double> color_from_depth;  ///< 16 numbers, row by row
    fresco::PixelCenter center = fresco::PixelCenter::half;
};

/// Each of the three parts from the options, else from its file in `path` (color-intrinsics.txt, depth-intrinsics.txt,
/// color_from_depth.txt), else the values that the makers of 7-Scenes name: focal length 585 and center (320, 240) at 640x480 for
/// both, and one place for both cameras; then `guesses` says so. Throws Error naming the option or the file and line.
Calibration read_calibration(const std::filesystem::path& path, const CalibrationOptions& options);

/// Intrinsics for pictures of this size. Throws Error if the matrix was assumed and the size is not the one it is for.
fresco::Intrinsics color_intrinsics(const Calibration& calibration, int width, int height);
fresco::Intrinsics depth_intrinsics(const Calibration& calibration, int width, int height);
