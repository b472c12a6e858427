#pragma once

#include <fresco/image.h>

#include <cstdint>
#include <optional>

namespace image_opencv
{

/// 8-bit RGB on white of a picture of 1 (gray), 3 (RGB) or 4 (RGBA, straight alpha) channels: v = (c a + white (1 - a)), computed
/// on the stored sRGB values as browsers do and rounded once. 16 bits: 65535 becomes 255. `transparent_gray`: gray pixels of
/// exactly this value are white.
fresco::Raster8 to_rgb(const fresco::Raster8& picture, std::optional<std::uint16_t> transparent_gray = std::nullopt);
fresco::Raster8 to_rgb(const fresco::Raster16& picture, std::optional<std::uint16_t> transparent_gray = std::nullopt);

/// 8-bit RGBA of a picture of 4 channels, straight alpha. 16 bits: 65535 becomes 255, rounded.
fresco::Raster8 to_rgba(const fresco::Raster8& picture);
fresco::Raster8 to_rgba(const fresco::Raster16& picture);

/// The picture as it is to be shown, for an EXIF orientation of 1..8 (EXIF 2.32, section 4.6.4): 5 to 8 swap width and height.
fresco::Raster8 oriented(fresco::Raster8 picture, int orientation);

}  // namespace image_opencv
