#pragma once

#include <fresco/recordings/registered_view.h>

#include <filesystem>
#include <string_view>
#include <vector>

namespace polycam
{

/// The folders of keyframes/ that hold one kind of them: as the phone recorded them, or corrected after the scan.
struct KeyframeFolders
{
    std::filesystem::path cameras;
    std::filesystem::path images;
    bool corrected = false;
};

/// The corrected ones where both of their folders are there, unless `recorded`. Throws MissingInput if the folders are not there.
KeyframeFolders keyframe_folders(const std::filesystem::path& scan, bool recorded);

/// One keyframe's camera: width, height, fx, fy, cx, cy (pixels, the first one's center at (0.5, 0.5)) and t_00 to t_23, the rows
/// of world_from_camera with OpenGL's camera axes, turned to OpenCV's here. Throws Error naming `source` and the key or byte.
void parse_camera(std::string_view text, const std::filesystem::path& source, fresco::recordings::RegisteredView& view);

/// The keyframes, by the time in their names: files only, no cameras. Depth pictures (millimeters) lie in keyframes/depth. Throws
/// MissingInput if there are none, or naming the pictures that are missing.
std::vector<fresco::recordings::RegisteredView> list_keyframes(const std::filesystem::path& scan, const KeyframeFolders& folders);

/// mesh_from_world of mesh_info.json: alignmentTransform, 16 numbers column by column. Throws Error naming `source`.
fresco::RigidTransform parse_alignment(std::string_view text, std::string_view source);

}  // namespace polycam
