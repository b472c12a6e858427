#include "opencv_codec.h"
#include "picture_info.h"

#include <string>

/// \file Where libheif is missing.

namespace image_opencv
{
namespace
{

[[noreturn]] void refuse_heif(std::string_view source)
{
    throw fresco::Error(std::string(source) +
                        ": a HEIC or AVIF picture, and this fresco was built without libheif, which reads "
                        "them; install libheif-dev and build fresco again, or convert the picture to PNG or "
                        "JPEG");
}

}  // namespace

PictureInfo check_heif(std::span<const std::byte>, std::string_view source, Walk)
{
    refuse_heif(source);
}

DecodedPicture decode_heif(std::span<const std::byte>, std::string_view source)
{
    refuse_heif(source);
}

}  // namespace image_opencv
