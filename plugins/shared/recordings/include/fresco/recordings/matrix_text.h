#pragma once

#include <fresco/camera.h>

#include <filesystem>
#include <string_view>
#include <vector>

/// \file Calibrations and poses as text: the small matrices that recorders write, one row per line.
namespace fresco::recordings
{

/// Strict reader of a rows x columns matrix: one row per line, numbers separated by blanks or tabs, in any locale; blank lines
/// are skipped. `nan` and `inf` are numbers here, the caller judges them. Throws Error "source:line: …" on anything that is no
/// number, a row of another length, too few or too many rows. Returns row-major values.
std::vector<double> parse_matrix_text(std::string_view text, int rows, int columns, std::string_view source);
/// The same for a file. Throws MissingInput if it cannot be read.
std::vector<double> read_matrix_text(const std::filesystem::path& file, int rows, int columns);

/// Row-major numbers separated by blanks on one line, exactly `count` of them. Throws Error naming `source`.
std::vector<double> parse_numbers(std::string_view text, std::size_t count, std::string_view source);

/// The rigid transform of a row-major 4x4 matrix. Throws Error naming `source` if an entry is not finite, the last row is not
/// 0 0 0 1 or the upper left part is no rotation (rotation_error > 1e-2, or a mirror). Written with few digits it is almost one:
/// the nearest rotation is taken.
RigidTransform rigid_transform(const std::vector<double>& matrix, std::string_view source);
RigidTransform read_rigid_transform(const std::filesystem::path& file);

/// Where a calibration puts the center of the first pixel.
enum class PixelCenter
{
    half,    ///< At (0.5, 0.5), as fresco does: cx = width / 2 is the middle.
    integer  ///< At (0, 0), as OpenCV's calibration does: cx = (width - 1) / 2 is the middle, and 0.5 is added.
};

/// Intrinsics of a row-major 3x3 or 4x4 matrix (fx 0 cx / 0 fy cy / 0 0 1). Throws Error naming `source` for skew, focal lengths
/// that are not positive, entries that are not finite, or anything else in the places of 0 and 1.
Intrinsics intrinsics_from_matrix(const std::vector<double>& matrix, PixelCenter center, int width, int height,
                                  std::string_view source);

}  // namespace fresco::recordings
