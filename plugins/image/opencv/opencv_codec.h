#pragma once

#include <fresco/image.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

/// \file Decodes and encodes pictures, for the component. OpenCV is included nowhere else; outside of it channels are in the
/// order RGB. Thread-safe: no state is shared.

namespace image_opencv
{

/// 8-bit RGB on white of a picture of 1 (gray), 3 (RGB) or 4 (RGBA, straight alpha) channels: v = (c a + white (1 - a)), computed
/// on the stored sRGB values as browsers do and rounded once. 16 bits: 65535 becomes 255. `transparent_gray`: gray pixels of
/// exactly this value are white. T: std::uint8_t or std::uint16_t, here and below.
template <class T>
fresco::Raster8 to_rgb(const fresco::Raster<T>& picture, std::optional<std::uint16_t> transparent_gray = std::nullopt);

/// 8-bit RGBA, straight alpha, of a picture of 4 channels, or of gray with transparent pixels of exactly `transparent_gray`. 16
/// bits: 65535 becomes 255, rounded.
template <class T>
fresco::Raster8 to_rgba(const fresco::Raster<T>& picture, std::optional<std::uint16_t> transparent_gray = std::nullopt);

/// The picture as displayed, for an EXIF orientation of 1..8 (EXIF 2.32, section 4.6.4): 5 to 8 swap width and height.
fresco::Raster8 oriented(fresco::Raster8 picture, int orientation);

using DecodedPicture = std::variant<fresco::Raster8, fresco::Raster16>;

/// A checked PNG or JPEG file as stored: 1 (gray), 3 (RGB) or 4 (RGBA) channels of 8 or 16 bits; palettes resolved, fewer bits
/// scaled to 8, CMYK turned to RGB; no orientation applied. Throws Error naming `source`.
DecodedPicture decode(std::span<const std::byte> bytes, std::string_view source);

/// A checked HEIC or AVIF file, by libheif: 3 (RGB) or 4 (RGBA, straight alpha) channels of 8 bits, or of 16 where it has more
/// than 8; cropped, turned and mirrored as the file says. Throws Error naming `source`, which says so where libheif or its
/// decoder is missing.
DecodedPicture decode_heif(std::span<const std::byte> bytes, std::string_view source);

/// Throw Error if the picture is empty, has another number of channels or is too large for the format.
template <class T>
std::vector<std::byte> encode_png(const fresco::Raster<T>& image);
std::vector<std::byte> encode_jpeg(const fresco::Raster8& image, int quality);

/// Version of the OpenCV this was compiled with.
const char* opencv_version();

}  // namespace image_opencv
