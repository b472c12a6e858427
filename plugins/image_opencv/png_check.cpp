#include "exif.h"
#include "picture_info.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>

namespace image_opencv
{
namespace
{

constexpr std::array<unsigned, 8> signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::uint32_t max_chunk_bytes = 0x7FFFFFFF;

constexpr std::uint32_t name(const char (&text)[5])
{
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
        value = value << 8U | static_cast<unsigned char>(text[i]);
    return value;
}

enum ColorType : unsigned
{
    gray = 0,
    rgb = 2,
    palette = 3,
    gray_alpha = 4,
    rgb_alpha = 6
};

bool depth_allowed(unsigned color_type, unsigned bits)
{
    switch (color_type)
    {
    case gray:
        return bits == 1 || bits == 2 || bits == 4 || bits == 8 || bits == 16;
    case palette:
        return bits == 1 || bits == 2 || bits == 4 || bits == 8;
    case rgb:
    case gray_alpha:
    case rgb_alpha:
        return bits == 8 || bits == 16;
    default:
        return false;
    }
}

class PngWalk
{
  public:
    PngWalk(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes, source) {}

    PictureInfo read(Walk walk)
    {
        for (std::size_t i = 0; i < signature.size(); ++i)
            if (bytes_.u8(i) != signature[i])
                bytes_.fail(i, "not a PNG file: its signature is damaged");
        header();
        if (walk == Walk::whole)
            while (!ended_)
                chunk();
        return info_;
    }

  private:
    /// Reads one chunk's frame, checks it and moves behind it.
    std::span<const std::byte> frame(std::uint32_t& type)
    {
        begin_ = next_;
        const std::uint32_t length = bytes_.u32(begin_);
        if (length > max_chunk_bytes)
            bytes_.fail(begin_, fmt::format("a chunk of {} bytes: the file is damaged", length));
        type = bytes_.u32(begin_ + 4);
        const auto checked = bytes_.part(begin_ + 4, std::size_t{length} + 4);
        next_ = begin_ + 12 + length;
        if (bytes_.u32(next_ - 4) != crc32_z(0, reinterpret_cast<const Bytef*>(checked.data()), checked.size()))
            bytes_.fail(begin_, "the chunk's checksum is wrong: the file is damaged; copy it again");
        return checked.subspan(4);
    }

    void header()
    {
        std::uint32_t type = 0;
        const auto data = frame(type);
        if (type != name("IHDR") || data.size() != 13)
            bytes_.fail(begin_, "expected an IHDR chunk of 13 bytes");
        const std::size_t at = begin_ + 8;
        bytes_.check_size(at, bytes_.u32(at), bytes_.u32(at + 4));
        info_.format = PictureFormat::png;
        info_.width = static_cast<int>(bytes_.u32(at));
        info_.height = static_cast<int>(bytes_.u32(at + 4));
        info_.bits = static_cast<int>(bytes_.u8(at + 8));
        color_type_ = bytes_.u8(at + 9);
        info_.is_gray = color_type_ == gray;
        if (!depth_allowed(color_type_, bytes_.u8(at + 8)))
            bytes_.fail(at + 8, fmt::format("color type {} with {} bits is not defined by PNG", color_type_, info_.bits));
        if (bytes_.u8(at + 10) != 0 || bytes_.u8(at + 11) != 0 || bytes_.u8(at + 12) > 1)
            bytes_.fail(at + 10, "unknown compression, filter or interlace method");
    }

    void chunk()
    {
        std::uint32_t type = 0;
        const auto data = frame(type);
        if (type == name("IHDR"))
            bytes_.fail(begin_, "a second IHDR chunk");
        if (type == name("IDAT"))
        {
            if (data_ended_)
                bytes_.fail(begin_, "the IDAT chunks are not consecutive");
            if (color_type_ == palette && !has_palette_)
                bytes_.fail(begin_, "the PLTE chunk is missing");
            has_data_ = true;
            return;
        }
        data_ended_ = has_data_;
        if (type == name("PLTE"))
            has_palette_ = true;
        else if (type == name("tRNS") && color_type_ == gray && data.size() == 2)
            info_.transparent_gray = static_cast<std::uint16_t>(bytes_.u16(begin_ + 8));
        else if (type == name("eXIf"))
            info_.orientation = exif_orientation(data);
        else if (type == name("IEND"))
        {
            if (!has_data_)
                bytes_.fail(begin_, "the picture has no IDAT chunk");
            ended_ = true;
        }
    }

    PictureBytes bytes_;
    PictureInfo info_;
    std::size_t begin_ = 0;
    std::size_t next_ = signature.size();
    unsigned color_type_ = 0;
    bool has_palette_ = false;
    bool has_data_ = false;
    bool data_ended_ = false;
    bool ended_ = false;
};

}  // namespace

PictureInfo check_png(std::span<const std::byte> bytes, std::string_view source, Walk walk)
{
    return PngWalk(bytes, source).read(walk);
}

}  // namespace image_opencv
