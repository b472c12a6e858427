#include "parsers.h"

#include "plugins/image/opencv/picture_info.h"

#include <zlib.h>

namespace fresco::fuzz
{
namespace
{

/// A PNG whose checksums are right, as far as it is one.
std::vector<std::byte> sealed(Bytes bytes)
{
    std::vector<std::byte> file(bytes.begin(), bytes.end());
    const auto byte = [&](std::size_t at) { return std::to_integer<std::size_t>(file[at]); };
    for (std::size_t at = 8; at + 12 <= file.size();)
    {
        const std::size_t length = byte(at) << 24U | byte(at + 1) << 16U | byte(at + 2) << 8U | byte(at + 3);
        if (length > file.size() - at - 12)
            break;
        const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(file.data() + at + 4), length + 4);
        at += 12 + length;
        for (std::size_t i = 0; i < 4; ++i)
            file[at - 4 + i] = static_cast<std::byte>(sum >> (24 - 8 * i) & 255U);
    }
    return file;
}

void read_picture(Bytes bytes)
{
    using namespace image_opencv;
    const bool is_png = !bytes.empty() && bytes[0] == std::byte{0x89};
    const auto file = is_png ? sealed(bytes) : std::vector<std::byte>(bytes.begin(), bytes.end());
    const PictureInfo whole = check_picture(file, source, Walk::whole);
    const PictureInfo size = check_picture(file, source, Walk::size);
    require(whole.width == size.width && whole.height == size.height, "one size, however far the file is read");
    require(whole.width > 0 && whole.height > 0 && whole.width <= max_pixels / whole.height, "a size that is supported");
    require(whole.orientation >= 1 && whole.orientation <= 8, "an orientation that EXIF has");
}

const Registered registered{{"picture", "plugins/image/opencv/(bmp|picture|webp)_info\\.cpp", read_picture}};

}  // namespace
}  // namespace fresco::fuzz
