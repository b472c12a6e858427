#pragma once

#include <fresco/recordings/recorded_view.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace nerfstudio
{

/// Which world the poses shall be in.
enum class World
{
    saved,    ///< That of the file.
    original  ///< That of the recorder: applied_transform and applied_scale undone.
};

struct Reading
{
    World world;
    double unit_m;                   ///< Meters per unit of the poses.
    double depth_unit_m;             ///< Meters per step of the depth pictures; 0: what the file says, else a millimeter.
    std::filesystem::path pictures;  ///< Folder that file_path is relative to; empty: the file's own.
};

struct Transforms
{
    std::vector<fresco::recordings::RecordedView> views;  ///< By name.
    bool has_masks = false;
};

/// The views of a transforms.json. Poses: world_from_camera with OpenGL camera axes (x right, y up, z backward), turned to
/// OpenCV's. The intrinsics of a frame go before those of the file; camera_angle_x stands in for fl_x. Depth belongs to the
/// color camera, as nerfstudio has it. \param file  where `text` is from: for errors, and pictures are beside it. Throws Error
/// naming file and byte (no JSON) or file, frame and key: a value that is missing or of another kind, a pose that is no rigid
/// transform, a camera model other than PINHOLE, SIMPLE_PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV and FULL_OPENCV, no frames, depth
/// in some frames only.
Transforms parse_transforms(std::string_view text, const std::filesystem::path& file, const Reading& reading);

}  // namespace nerfstudio
