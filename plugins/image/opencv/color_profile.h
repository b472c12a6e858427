#pragma once

#include "opencv_codec.h"

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

/// \file Colors of other profiles than sRGB become sRGB, through Little CMS 2. Where that is missing, only profiles that
/// speak of sRGB are taken. Thread-safe: no state is shared.

namespace image_opencv
{

/// Ends what a C library opened, in a std::unique_ptr.
template <auto close>
struct Closing
{
    template <class T>
    void operator()(T* handle) const
    {
        close(handle);
    }
};

/// The picture in sRGB, relative colorimetric with black point compensation; alpha stays. A profile within 1/255 of sRGB changes
/// nothing, nor does one of CMYK, which decoding has turned to RGB without it; a picture of gray whose profile is of colors gets
/// 3 channels. `icc` is empty for none. Throws Error naming `source` for a damaged profile and for one that is not of RGB, gray
/// or CMYK.
DecodedPicture in_srgb(DecodedPicture picture, std::span<const std::byte> icc, std::string_view source);

/// An ICC profile of primaries: x and y of red, green, blue and white (CIE 1931). `gamma` 0: sRGB's curve. Throws Error naming
/// `source` where Little CMS is missing, and for primaries that span no colors.
std::vector<std::byte> icc_of_primaries(const std::array<float, 8>& xy, double gamma, std::string_view source);

}  // namespace image_opencv
