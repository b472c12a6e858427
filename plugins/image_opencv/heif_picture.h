#pragma once

#include "opencv_codec.h"
#include "picture_info.h"

/// \file HEIC and AVIF pictures, through libheif. Thread-safe.

namespace image_opencv
{

/// A checked file: 3 (RGB) or 4 (RGBA, straight alpha) channels of 8 bits, or of 16 where it has more than 8; cropped, turned and
/// mirrored as the file says. Throws Error naming `source`, which says so where libheif or its decoder is missing.
DecodedPicture decode_heif(std::span<const std::byte> bytes, std::string_view source);

}  // namespace image_opencv
