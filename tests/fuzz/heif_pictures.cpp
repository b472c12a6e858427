#include "parsers.h"

#include "plugins/image/opencv/picture_info.h"

namespace fresco::fuzz
{
namespace
{

void read_heif_picture(Bytes bytes)
{
    using namespace image_opencv;
    const PictureInfo info = check_heif(bytes, source, Walk::whole);
    require(info.width > 0 && info.height > 0 && info.width <= max_pixels / info.height, "a size that is supported");
    require(info.orientation == 1, "turned by the decoder");
}

const Registered registered_heif{{"heif_picture", "plugins/image/opencv/heif_picture\\.cpp", read_heif_picture}};

}  // namespace
}  // namespace fresco::fuzz
