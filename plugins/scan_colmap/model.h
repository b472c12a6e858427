#pragma once

#include "camera_models.h"

#include <fresco/math.h>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace colmap
{

using Cameras = std::map<std::int64_t, ModelCamera>;  ///< By id.

/// A picture that COLMAP placed. Its points are not kept.
struct ModelImage
{
    fresco::RigidTransform world_from_camera;
    std::int64_t camera = 0;  ///< Id.
    std::string name;         ///< Path below the folder of pictures.
    std::string source;       ///< Where it stands, for errors.
};

/// The contents of cameras.txt and images.txt. Comments are passed over, but the counts that COLMAP writes in them are checked.
/// Throws Error "source:line: …", also for a file that is cut.
Cameras parse_cameras_text(std::string_view text, std::string_view source);
std::vector<ModelImage> parse_images_text(std::string_view text, std::string_view source);

/// The contents of cameras.bin and images.bin, little-endian. Nothing is allocated for counts that the file does not hold. Throws
/// Error "source: byte offset: …", also for a file that is cut or has bytes after its end.
Cameras parse_cameras_binary(std::span<const std::byte> bytes, std::string_view source);
std::vector<ModelImage> parse_images_binary(std::span<const std::byte> bytes, std::string_view source);

}  // namespace colmap
