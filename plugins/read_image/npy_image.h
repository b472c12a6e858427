#pragma once

#include <fresco/image.h>

#include <filesystem>

namespace read_image
{

/// A picture of type uint8 and shape H x W, H x W x 1, H x W x 3 or H x W x 4, at most 300 megapixels. Throws MissingInput if the
/// file cannot be read, Error naming it and what it holds otherwise.
fresco::Image image_from_npy(const std::filesystem::path& file);

}  // namespace read_image
