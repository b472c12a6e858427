#include "picture_bytes.h"

#include <bit>
#include <cstdlib>

/// \file BMP as models of older programs use it: headers of 40 bytes or more, not compressed. OpenCV decodes it.

namespace image_opencv
{
namespace
{

constexpr std::size_t file_header_bytes = 14;
constexpr std::size_t least_info_bytes = 40;
constexpr std::uint32_t uncompressed = 0;
constexpr std::uint32_t with_masks = 3;

}  // namespace

PictureInfo check_bmp(std::span<const std::byte> bytes, std::string_view source, Walk walk)
{
    const PictureBytes file(bytes, source);
    const auto number = [&](std::size_t at) { return file.u32_little(at); };
    if (!file.has(0, "BM") || number(file_header_bytes) < least_info_bytes)
        file.fail(0, "not a BMP file of Windows 3 or newer; save the picture as PNG");
    PictureInfo info;
    // Rows go up, or down if the height is negative.
    const std::int64_t height = std::bit_cast<std::int32_t>(number(22));
    file.take_size(info, 18, std::bit_cast<std::int32_t>(number(18)), std::abs(height));
    const unsigned bits = number(28) & 0xFFFFU;
    const std::uint32_t compression = number(30);
    const bool is_plain = compression == uncompressed && (bits == 1 || bits == 4 || bits == 8 || bits == 24 || bits == 32);
    const bool is_masked =
        compression == with_masks && bits == 32 && number(54) == 0xFF0000 && number(58) == 0xFF00 && number(62) == 0xFF;
    if (!is_plain && !is_masked)
        file.fail(28, fmt::format("a BMP picture of {} bits, compression {}; save it as PNG", bits, compression));
    const std::size_t data = number(10);
    const std::size_t colors = bits > 8 ? 0 : number(46) == 0 ? std::size_t{1} << bits : number(46);
    if (data < file_header_bytes + number(file_header_bytes) + 4 * colors)
        file.fail(10, "the pixels begin inside the header: the file is damaged");
    const std::size_t row = (std::size_t{bits} * static_cast<std::size_t>(info.width) + 31) / 32 * 4;
    if (walk == Walk::whole)
        static_cast<void>(file.part(data, row * static_cast<std::size_t>(info.height)));
    return info;
}

}  // namespace image_opencv
