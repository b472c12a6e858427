#include "color_profile.h"

#include <fresco/error.h>

#include <string>

/// \file Where Little CMS 2 is missing.

namespace image_opencv
{
namespace
{

[[noreturn]] void refuse_colors(std::string_view source)
{
    throw fresco::Error(std::string(source) +
                        ": its colors are not sRGB, and this fresco was built without Little CMS 2, which converts them; install "
                        "liblcms2-dev and build fresco again, or convert the picture to sRGB");
}

/// Whether the profile speaks of sRGB, in ASCII or UTF-16.
bool names_srgb(std::span<const std::byte> icc)
{
    std::string text;
    for (const std::byte byte : icc)
        if (byte != std::byte{0})
            text += static_cast<char>(byte);
    return text.find("sRGB") != std::string::npos;
}

}  // namespace

DecodedPicture in_srgb(DecodedPicture picture, std::span<const std::byte> icc, std::string_view source)
{
    if (!icc.empty() && !names_srgb(icc))
        refuse_colors(source);
    return picture;
}

std::vector<std::byte> icc_of_primaries(const std::array<float, 8>&, double, std::string_view source)
{
    refuse_colors(source);
}

}  // namespace image_opencv
