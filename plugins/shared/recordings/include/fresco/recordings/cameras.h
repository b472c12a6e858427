#pragma once

#include <fresco/image_io.h>
#include <fresco/recordings/matrix_text.h>
#include <fresco/recordings/recorded_view.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// \file Cameras and poses in the conventions of recorders.
namespace fresco::recordings
{

/// A camera's matrix, before the size of its pictures is known.
struct CameraMatrix
{
    std::vector<double> values;  ///< Row-major 3x3 or 4x4, pixels.
    std::string source;          ///< The file or option it is from, for errors.
};

/// Intrinsics for pictures of `size`, such as `picture`. Throws Error as intrinsics_from_matrix and check_center do.
Intrinsics intrinsics_for(const CameraMatrix& matrix, PixelCenter center, const ImageHeader& size,
                          const std::filesystem::path& picture);

/// A recorder's color and depth camera, with the pose of the depth camera as the pose of a view.
struct RecorderCameras
{
    Intrinsics color;
    Intrinsics depth;
    RigidTransform depth_from_color;  ///< X_depth = depth_from_color(X_color), meters.

    /// Sets both cameras of a view.
    void place(RecordedView& view, const RigidTransform& world_from_depth) const;
};

/// The rigid transform of a row-major 4x4 matrix; nothing where an entry is not finite: the recorder had lost track. Throws Error
/// naming `source` as rigid_transform does.
std::optional<RigidTransform> tracked_pose(const std::vector<double>& matrix, const std::string& source);

/// world_from_camera with OpenCV's camera axes (x right, y down, z forward) of a row-major 4x4 matrix with OpenGL's (x right, y
/// up, z backward). Throws Error naming `source` as rigid_transform does.
RigidTransform opencv_pose(std::vector<double> matrix, const std::string& source);

}  // namespace fresco::recordings
