#include "picture_bytes.h"

#include <algorithm>

/// \file WebP: a RIFF file of chunks (RFC 9649). OpenCV decodes it.

namespace image_opencv
{
namespace
{

constexpr std::size_t riff_header_bytes = 12;
constexpr std::size_t chunk_header_bytes = 8;

enum ExtendedFlag : unsigned
{
    animated = 0x02,
    transparent = 0x10
};

class WebpWalk
{
  public:
    WebpWalk(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes, source) {}

    PictureInfo read(Walk walk)
    {
        const std::size_t end = chunk_header_bytes + std::size_t{bytes_.u32_little(4)};
        if (walk == Walk::whole)
            static_cast<void>(bytes_.part(0, end));
        std::size_t next = riff_header_bytes;
        do
        {
            const std::size_t length = bytes_.u32_little(next + 4);
            if (next + chunk_header_bytes + length > end)
                bytes_.fail(next, fmt::format("a chunk of {} bytes in a file of {}: the file is damaged", length, end));
            chunk(next, length, next == riff_header_bytes, walk);
            next += chunk_header_bytes + length + length % 2;
        } while (walk == Walk::whole && next < end);
        if (walk == Walk::whole && !has_data_)
            bytes_.fail(next, "the picture has no data (VP8 or VP8L chunk): the file is damaged");
        return info_;
    }

  private:
    void chunk(std::size_t begin, std::size_t length, bool is_first, Walk walk)
    {
        const std::size_t at = begin + chunk_header_bytes;
        const bool is_lossy = bytes_.has(begin, "VP8 ");
        const bool is_lossless = bytes_.has(begin, "VP8L");
        if (is_first && bytes_.has(begin, "VP8X"))
        {
            if ((bytes_.u8(at) & animated) != 0)
                bytes_.fail(at, "a moving WebP picture; save one of its pictures by itself");
            info_.has_alpha = (bytes_.u8(at) & transparent) != 0;
            bytes_.take_size(info_, at + 4, 1 + (bytes_.u32_little(at + 4) & 0xFFFFFFU), 1 + (bytes_.u32_little(at + 6) >> 8U));
        }
        else if (is_first && is_lossy)
        {
            if (!bytes_.has(at + 3, "\x9D\x01\x2A"))
                bytes_.fail(at + 3, "expected the start of a VP8 key frame: the file is damaged");
            const std::uint32_t sides = bytes_.u32_little(at + 6);
            bytes_.take_size(info_, at + 6, sides & 0x3FFFU, sides >> 16U & 0x3FFFU);
        }
        else if (is_first && is_lossless)
        {
            if (bytes_.u8(at) != 0x2F)
                bytes_.fail(at, "expected the signature of VP8L: the file is damaged");
            const std::uint32_t sides = bytes_.u32_little(at + 1);
            info_.has_alpha = (sides >> 28U & 1U) != 0;
            bytes_.take_size(info_, at + 1, 1 + (sides & 0x3FFFU), 1 + (sides >> 14U & 0x3FFFU));
        }
        else if (is_first)
            bytes_.fail(begin, "expected a VP8, VP8L or VP8X chunk: the file is damaged");
        has_data_ = has_data_ || is_lossy || is_lossless;
        if (walk != Walk::whole)
            return;
        const auto data = bytes_.part(at, length);
        if (bytes_.has(begin, "ICCP"))
            info_.profile.assign(data.begin(), data.end());
        else if (bytes_.has(begin, "EXIF"))
            info_.orientation =
                exif_orientation(data.subspan(bytes_.has(at, {"Exif\0\0", 6}) ? std::min<std::size_t>(6, length) : 0));
    }

    PictureBytes bytes_;
    PictureInfo info_;
    bool has_data_ = false;
};

}  // namespace

PictureInfo check_webp(std::span<const std::byte> bytes, std::string_view source, Walk walk)
{
    return WebpWalk(bytes, source).read(walk);
}

}  // namespace image_opencv
