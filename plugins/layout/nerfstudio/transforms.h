#pragma once

#include <fresco/recordings/recorded_view.h>

#include <fresco/image_io.h>
#include <fresco/run_context.h>

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace nerfstudio
{

struct Reading
{
    bool original_world = false;       ///< The recorder's: applied_transform and applied_scale undone.
    std::filesystem::path pictures{};  ///< Folder that file_path is relative to; empty: the file's own.
    std::filesystem::path masks{};     ///< Folder that mask_path is relative to.
    std::string split = "all";         ///< all: `frames`; train, val, test: those that the file's lists name.
    /// The size of a picture, for cameras without one.
    std::function<fresco::ImageHeader(const std::filesystem::path&)> size_of{};
};

/// The views of a transforms.json, by name. Poses: world_from_camera with OpenGL camera axes (x right, y up, z backward), turned
/// to OpenCV's. The intrinsics of a frame go before those of the file; camera_angle_x stands in for fl_x. Depth belongs to the
/// color camera, as nerfstudio has it. Files that are not where they are listed are looked for (find_listed_files). A pose with
/// an entry that is not finite has a translation that is not. \param file  where `text` is from: for errors, and pictures are
/// beside it. Throws Error naming file and byte (no JSON) or file, frame and key: a value that is missing or of another kind, a
/// pose that is no rigid transform, a camera model other than PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV
/// and OPENCV_FISHEYE, no frames, a split that the file does not tell.
std::vector<fresco::recordings::RecordedView> parse_transforms(std::string_view text, const std::filesystem::path& file,
                                                               const Reading& reading, fresco::RunContext& run);

}  // namespace nerfstudio
