#pragma once

#include <fresco/error.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// \file What the bytes of a PNG or JPEG file say about the picture, checked without decoding it. No picture library is used
/// here: OpenCV fills up what is missing of a JPEG and believes any size a header claims.

namespace image_opencv
{

inline constexpr std::int64_t max_pixels = 300'000'000;

enum class PictureFormat
{
    png,
    jpeg
};

/// How far a file is walked.
enum class Walk
{
    size,  ///< Up to the picture's size.
    whole  ///< To its end: a file that is cut anywhere is refused.
};

struct PictureInfo
{
    PictureFormat format = PictureFormat::png;
    int width = 0;   ///< Before orientation, as all sizes here.
    int height = 0;  ///< width * height <= max_pixels.
    int bits = 8;    ///< Per sample as stored: 1, 2, 4, 8 or 16.
    bool is_gray = false;
    int orientation = 1;                            ///< EXIF, 1..8; known after Walk::whole.
    std::optional<std::uint16_t> transparent_gray;  ///< PNG color key of a gray picture, as stored.
};

/// The bytes end before the picture does.
class CutPicture final : public fresco::Error
{
  public:
    using fresco::Error::Error;
};

/// Throw Error naming `source` and the byte offset; CutPicture where the bytes end too early.
PictureInfo check_png(std::span<const std::byte> bytes, std::string_view source, Walk walk);
PictureInfo check_jpeg(std::span<const std::byte> bytes, std::string_view source, Walk walk);
/// Either of them by the first bytes; throws Error if it is neither.
PictureInfo check_picture(std::span<const std::byte> bytes, std::string_view source, Walk walk);

/// Size of a file's picture; reads no more of the file than it needs. Throws MissingInput if it cannot be read.
PictureInfo picture_size(const std::filesystem::path& file);

/// Reads big-endian numbers and fails with the file's name and the offset.
class PictureBytes
{
  public:
    PictureBytes(std::span<const std::byte> bytes, std::string_view source) : bytes_(bytes), source_(source) {}

    std::size_t size() const { return bytes_.size(); }
    unsigned u8(std::size_t at) const { return std::to_integer<unsigned>(part(at, 1)[0]); }
    unsigned u16(std::size_t at) const { return u8(at) << 8U | u8(at + 1); }
    std::uint32_t u32(std::size_t at) const { return std::uint32_t{u16(at)} << 16U | u16(at + 2); }
    std::span<const std::byte> part(std::size_t at, std::size_t count) const
    {
        if (at > bytes_.size() || count > bytes_.size() - at)
            throw CutPicture(place(bytes_.size()) + "the file ends inside the picture: it is truncated; copy it again");
        return bytes_.subspan(at, count);
    }
    [[noreturn]] void fail(std::size_t at, const std::string& what) const { throw fresco::Error(place(at) + what); }
    /// Refuses sizes that no reader here takes; `at`: where the size stands.
    void check_size(std::size_t at, std::int64_t width, std::int64_t height) const;

  private:
    std::string place(std::size_t at) const { return fmt::format("{}: byte {}: ", source_, at); }

    std::span<const std::byte> bytes_;
    std::string_view source_;
};

}  // namespace image_opencv
