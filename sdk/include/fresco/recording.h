#pragma once

#include <fresco/camera.h>
#include <fresco/frames.h>
#include <fresco/image_io.h>
#include <fresco/progress.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// \file What readers of recorded RGB-D views do alike, whatever the layout of their folders.

namespace fresco
{

/// The files of one recorded view.
struct ViewFiles
{
    std::string sequence;  ///< File-name safe, such as "seq-01".
    std::string name;      ///< File-name safe, such as "frame-000008".
    long number = 0;       ///< Counts in recorded order within the sequence.
    std::filesystem::path color;
    std::filesystem::path depth;
    std::filesystem::path pose;
};

/// The recorder's two cameras. All color pictures have the size of `color`, all depth pictures that of `depth`.
struct RecorderCameras
{
    Intrinsics color;
    Intrinsics depth;
    RigidTransform depth_from_color;  ///< X_depth = depth_from_color(X_color), meters.
};

/// Throws MissingInput that counts `missing`, names the first of them and says `rule`; does nothing if it is empty.
void refuse_missing(const std::vector<std::string>& missing, std::string_view rule);

/// Throws Error naming `source` if the principal point is outside of `picture`, for which `k` is: then the intrinsics are for
/// pictures of another size.
void check_center(const Intrinsics& k, const std::string& source, const std::filesystem::path& picture);

/// Throws Error naming `file` if its EXIF data turns it, as ImageIo::check tells: the pose and lens that `source` states are for
/// the pixels as they are stored.
void check_not_turned(const std::filesystem::path& file, const ImageHeader& header, const std::string& source);

/// Throws Error naming `file` unless ImageIo::check found 16-bit gray in it, or did not look.
void check_depth_kind(const std::filesystem::path& file, const ImageHeader& header);

/// world_from_depth of a view; nothing where the recorder had lost track.
using PoseReader = std::function<std::optional<RigidTransform>(const ViewFiles&)>;

/// Cameras and content hashes of the views, in their order; views without a pose are left out. world_from_color =
/// world_from_depth * depth_from_color. Pictures are not decoded, but their files are walked to the end. `read_pose` is called
/// from several threads.
/// Throws Error naming the file: a picture that is cut or of another size than its camera's, a color picture that EXIF turns, a
/// depth picture that is not 16-bit gray, a pose that check_camera refuses, what `read_pose` throws.
Frames posed_frames(const std::vector<ViewFiles>& views, const RecorderCameras& cameras, const PoseReader& read_pose,
                    const ImageIo& images, Progress& progress);

}  // namespace fresco
