#pragma once

#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/progress.h>
#include <fresco/recordings/lens.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// \file Views as recordings tell them, and the frames made of them.
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
    std::filesystem::path mask;        ///< Of the color picture's size, black where it is to be ignored; empty: none.
    std::filesystem::path pose;        ///< The view's own file of pose or camera; empty: none.
    Intrinsics camera;                 ///< Of the color picture.
    Lens lens;                         ///< Of the color camera.
    RigidTransform world_from_camera;  ///< Of the color camera.
    /// None: the depth picture is registered to the color camera. It has that camera's shape and field of view, at any size.
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

/// Frames of the views, in their order. Pictures without a lens to undo stay where they are: paths and content hashes, their
/// files walked to the end. Others are undistorted into `folder`: <sequence>/<name>.color.jpg (quality 95) and .depth.png; each
/// thread holds one picture. A view without depth gives a frame without; its depth camera is the color camera.
/// A mask that ignores anything is written as <sequence>/<name>.mask.npy, and so is the depth picture, without the surface that
/// the color camera sees at ignored pixels.
/// Throws Error naming the file or `source`: a picture or mask that is cut or of another size than its camera's, a depth picture
/// that is not 16-bit gray or of another shape, a color picture that EXIF turns, a camera or pose that check_camera refuses, a
/// principal point outside of its picture, two views of one name; what `unpack` throws.
Frames recorded_frames(const std::vector<RecordedView>& views, const ImageIo& images, const std::filesystem::path& folder,
                       Progress& progress, const UnpackView& unpack = {});

}  // namespace fresco::recordings
