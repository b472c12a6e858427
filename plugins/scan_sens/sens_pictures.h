#pragma once

#include "sens_file.h"

#include <fresco/image_io.h>

#include <filesystem>
#include <string>

namespace sens
{

/// Writes the color picture of a frame to `folder`/`name`.color.jpg: JPEG and PNG as they are, the latter and raw ones as .png.
/// Throws Error naming file and byte for one that is too large for its size, or raw and of another size. Returns the file.
std::filesystem::path write_color(const SensFile& file, const SensIndex& index, const SensFrame& frame,
                                  const fresco::ImageIo& images, const std::filesystem::path& folder, const std::string& name);

/// Writes the depth picture of a frame to `folder`/`name`.depth.png. Throws Error naming file and byte as write_color, and for
/// packed values that are damaged. Returns the file.
std::filesystem::path write_depth(const SensFile& file, const SensIndex& index, const SensFrame& frame,
                                  const fresco::ImageIo& images, const std::filesystem::path& folder, const std::string& name);

}  // namespace sens
