#pragma once

#include "picture_info.h"

#include <fmt/format.h>

#include <cstring>

namespace image_opencv
{

/// Reads big-endian numbers, as most pictures store them, and fails with the file's name and the offset.
class PictureBytes
{
  public:
    PictureBytes(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes), source_(source) {}

    std::size_t size() const { return bytes_.size(); }
    unsigned u8(std::size_t at) const { return std::to_integer<unsigned>(part(at, 1)[0]); }
    unsigned u16(std::size_t at) const { return u8(at) << 8U | u8(at + 1); }
    std::uint32_t u32(std::size_t at) const { return std::uint32_t{u16(at)} << 16U | u16(at + 2); }
    std::uint32_t u32_little(std::size_t at) const
    {
        return u8(at) | u8(at + 1) << 8U | u8(at + 2) << 16U | std::uint32_t{u8(at + 3)} << 24U;
    }
    bool has(std::size_t at, std::string_view text) const
    {
        return at <= size() && text.size() <= size() - at && std::memcmp(bytes_.data() + at, text.data(), text.size()) == 0;
    }
    std::span<const std::byte> part(std::size_t at, std::size_t count) const
    {
        if (at > bytes_.size() || count > bytes_.size() - at)
            throw CutPicture(place(bytes_.size()) + "the file ends inside the picture: it is truncated; copy it again");
        return bytes_.subspan(at, count);
    }
    [[noreturn]] void fail(std::size_t at, const std::string& what) const { throw fresco::Error(place(at) + what); }
    /// Refuses sizes that no reader here takes; `at`: where the size stands.
    void take_size(PictureInfo& info, std::size_t at, std::int64_t width, std::int64_t height) const
    {
        const auto text = fmt::format("{} x {} pixels", width, height);
        if (width < 1 || height < 1)
            fail(at, "the picture has " + text);
        // Both are below 2^32, so the product may not fit: divide.
        if (width > max_pixels / height)
            fail(at, fmt::format("the picture has {}; at most {} megapixels are supported: shrink it first", text,
                                 max_pixels / 1'000'000));
        info.width = static_cast<int>(width);
        info.height = static_cast<int>(height);
    }

  private:
    std::string place(std::size_t at) const { return fmt::format("{}: byte {}: ", source_, at); }

    std::span<const std::byte> bytes_;
    std::string_view source_;
};

}  // namespace image_opencv
