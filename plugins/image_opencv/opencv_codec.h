#pragma once

#include <fresco/image.h>

#include <cstddef>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

/// \file The one place that includes OpenCV. Channels are in the order RGB outside of it. Thread-safe: nothing is shared.

namespace image_opencv
{

using DecodedPicture = std::variant<fresco::Raster8, fresco::Raster16>;

/// A checked PNG or JPEG file as stored: 1 (gray), 3 (RGB) or 4 (RGBA) channels of 8 or 16 bits; palettes resolved, fewer bits
/// scaled to 8, CMYK turned to RGB; no orientation applied. Throws Error naming `source`.
DecodedPicture decode(std::span<const std::byte> bytes, std::string_view source);

/// Throw Error if the picture is empty, has another number of channels or is too large for the format.
std::vector<std::byte> encode_png(const fresco::Raster8& image);
std::vector<std::byte> encode_png(const fresco::Raster16& image);
std::vector<std::byte> encode_jpeg(const fresco::Raster8& image, int quality);

/// Version of the OpenCV this was compiled with.
const char* opencv_version();

}  // namespace image_opencv
