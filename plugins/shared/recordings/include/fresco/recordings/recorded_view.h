#pragma once

#include <fresco/camera.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/parallel.h>
#include <fresco/recordings/lens.h>
#include <fresco/recordings/parsing.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// \file Views as recordings tell them, with their cameras and poses, and the frames made of them.

namespace fresco::recordings
{

/// One view as recorded.
struct RecordedView
{
    std::string sequence;  ///< File-name safe.
    std::string name;      ///< File-name safe, unique in its sequence.
    long number = 0;
    std::filesystem::path color;
    std::filesystem::path depth;       ///< Empty: none.
    std::filesystem::path mask;        ///< Mask of the color picture's size, black where it is to be ignored; empty: none.
    std::filesystem::path pose;        ///< The view's own file of pose or camera; empty: none.
    bool is_panorama = false;          ///< The pictures are 360° pictures (panorama.h), and so is the depth picture.
    Intrinsics camera;                 ///< Intrinsics of the color picture; only the size of a panorama.
    Lens lens;                         ///< Lens of the color camera; none for a panorama.
    RigidTransform world_from_camera;  ///< Pose of the color camera.
    /// Missing if the depth picture is registered to the color camera. It has that camera's shape and field of view, at any size.
    std::optional<Camera> depth_camera;
    double depth_unit_m = 0.001;
    std::string source;  ///< Origin of the camera and the pose, such as "traj.txt:3", for errors.
};

/// Names of a picture as its recording lists it ("images/frame_00012.jpg"): sequence "images" ("scan" without a folder), name
/// "frame_00012", other characters than letters, digits and -_. as '_'.
void name_by_picture(RecordedView& view, const std::filesystem::path& listed);

/// Sorts by sequence and name, digits as numbers, and numbers the views: by the last number of their names where these are unique
/// in each sequence, else by their place in the order.
void order_by_name(std::vector<RecordedView>& views);

/// Writes the pictures of a view that lie within a larger file into `folder`, and sets their paths; false: they are files of
/// their own. Called from several threads.
using UnpackView = std::function<bool(RecordedView& view, const std::filesystem::path& folder)>;

/// The offset of the frames, for a mesh with these positions of the world. Throws Error naming `source`, the mesh's file, if the
/// two are more than 100 km apart.
Vec3d offset_beside(Vec3d frames_offset_m, std::span<const Vec3d> mesh, const std::string& source);

/// Frames of the views, in their order. Pictures without a lens to undo stay where they are: paths and content hashes, their
/// files walked to the end. Others are undistorted into `folder`: <sequence>/<name>.color.jpg (quality 95) and .depth.png; each
/// thread holds one picture. A view without depth gives a frame without; its depth camera is the color camera.
///
/// A panorama gives six frames, as if six cameras had recorded: of the sequences <sequence>_front, _right, _back, _left, _up and
/// _down, so that neighbors in a sequence see much the same. First come all in front, and so on. Their pictures are written as
/// those without a lens.
///
/// A mask that ignores anything is written as <sequence>/<name>.mask.npy, and so is the depth picture, without the surface that
/// the color camera sees at ignored pixels. Transparent pixels of the color picture are ignored, too; `transparent_count` gets
/// the number of pictures that have any.
///
/// Throws Error naming the file or `source`: a picture or mask that is cut or of another size than its camera's, a depth picture
/// that is not 16-bit gray or of another shape, a color picture without opaque pixels, a panorama that is not twice as wide as
/// high, a color picture that EXIF turns, a camera or pose that check_camera refuses, a principal point outside of its picture,
/// two views of one name; what `unpack` throws.
Frames recorded_frames(const std::vector<RecordedView>& views, const ImageIo& images, const std::filesystem::path& folder,
                       Progress& progress, const UnpackView& unpack = {}, std::size_t* transparent_count = nullptr);

/// An error's text with `name` in place of a path that the user has never seen, such as that of a copy in the store. `name` leads
/// a text without that path.
std::string renamed(std::string error, const std::filesystem::path& hidden, const std::string& name);

/// A camera's matrix, before the size of its pictures is known.
struct CameraMatrix
{
    std::vector<double> values;  ///< Row-major 3x3 or 4x4, pixels.
    std::string source;          ///< The file or option it is from, for errors.
};

/// Intrinsics for pictures of `size`, such as `picture`. Throws Error as intrinsics_from_matrix does, and if the principal point
/// is outside of the picture: then they are for pictures of another size.
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

/// Throws Error naming `file` if its EXIF data turns it, as ImageIo::check reports: the pose and lens that `source` states are
/// for the pixels as they are stored.
void check_not_turned(const std::filesystem::path& file, const ImageHeader& header, const std::string& source);

}  // namespace fresco::recordings
