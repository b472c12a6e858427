#pragma once

#include <cstddef>
#include <span>

namespace image_opencv
{

/// The orientation (tag 0x0112, 1..8) in a TIFF block as EXIF embeds it. 1 where it is missing or the block is malformed: many
/// programs write faulty metadata beside sound pictures.
int exif_orientation(std::span<const std::byte> tiff);

}  // namespace image_opencv
