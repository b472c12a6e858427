#pragma once

#include <fresco/error.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

/// \file Checks pictures without decoding them, and tells their size, kind and color profile. The component checks every file
/// before it is decoded, because OpenCV completes truncated JPEGs and trusts any size in a header; the fuzzer calls it, too.

namespace image_opencv
{

inline constexpr std::int64_t max_pixels = 300'000'000;

/// How much of a file to check.
enum class Walk
{
    size,  ///< Up to the picture's size.
    whole  ///< To its end, so that a truncated file is refused.
};

struct PictureInfo
{
    bool is_heif = false;  ///< HEIC or AVIF.
    int width = 0;         ///< Before orientation, like all sizes here.
    int height = 0;        ///< width * height <= max_pixels.
    int bits = 8;          ///< Per sample as stored: 1, 2, 4, 8, 10, 12 or 16.
    bool is_gray = false;
    bool has_alpha = false;                         ///< Pixels may be transparent; known after Walk::whole.
    int orientation = 1;                            ///< EXIF, 1..8; known after Walk::whole.
    std::optional<std::uint16_t> transparent_gray;  ///< PNG color key of a gray picture, as stored.
    std::vector<std::byte> profile;                 ///< ICC, not looked into; empty: none. Known after Walk::whole.
};

/// The bytes end inside the picture.
class CutPicture final : public fresco::Error
{
  public:
    using fresco::Error::Error;
};

/// Throw Error naming `source` and the byte offset; CutPicture if the bytes end too early.
PictureInfo check_png(std::span<const std::byte> bytes, std::string_view source, Walk walk);
PictureInfo check_jpeg(std::span<const std::byte> bytes, std::string_view source, Walk walk);
PictureInfo check_webp(std::span<const std::byte> bytes, std::string_view source, Walk walk);
PictureInfo check_bmp(std::span<const std::byte> bytes, std::string_view source, Walk walk);
/// Through libheif, whose errors know no offset; where it is missing, the Error says so. Turned as the file says: orientation 1.
PictureInfo check_heif(std::span<const std::byte> bytes, std::string_view source, Walk walk);
/// Any of these, told apart by the first bytes. Throws Error for another format, which it names where it knows it.
PictureInfo check_picture(std::span<const std::byte> bytes, std::string_view source, Walk walk);

/// Size of a file's picture; reads no more of the file than it needs. Throws MissingInput if it cannot be read.
PictureInfo picture_size(const std::filesystem::path& file);

/// The orientation (tag 0x0112, 1..8) in a TIFF block as EXIF embeds it. 1 if it is missing or the block is malformed, because
/// many programs write faulty metadata beside sound pictures. Declared for tests.
int exif_orientation(std::span<const std::byte> tiff);

}  // namespace image_opencv
