#pragma once

#include <fresco/component.h>
#include <fresco/image.h>
#include <fresco/option_declaration.h>

#include <cstddef>
#include <filesystem>
#include <vector>

namespace fresco
{

/// PNG, JPEG, WebP, HEIC and AVIF.
std::vector<FileFormat> picture_formats();

/// Size of a picture as its header states it (before EXIF orientation).
struct ImageHeader
{
    int width = 0;
    int height = 0;
    int bits = 0;         ///< Per sample as stored; 0 = not looked at.
    bool gray = false;    ///< One channel; meaningful where bits > 0.
    int orientation = 1;  ///< EXIF's, 1 to 8, which read_rgb applies; 1 where it was not looked at.
    bool alpha = false;   ///< Pixels may be transparent; false where it was not looked at.
};

/// Pixels of less alpha count as transparent: nothing was recorded there, and nothing can be copied from there. The codecs of
/// some formats do not keep 255 exactly.
inline constexpr int least_opaque_alpha = 250;

/// Reads and writes picture files: the contract behind `image.opencv`. Thread-safe. Every reader checks the header first
/// (limit: 300 megapixels) and refuses a picture that is cut short; errors name the file.
class ImageIo : public Component
{
  public:
    static constexpr std::string_view component_kind = "image_io";
    static constexpr std::string_view default_type = "image.opencv";
    ~ImageIo() override;

    /// Size without decoding.
    virtual ImageHeader header(const std::filesystem::path& file) const = 0;
    /// Header with the kind of samples, after a walk over the whole file without decoding it: a truncated picture is
    /// refused. The default calls header().
    virtual ImageHeader check(const std::filesystem::path& file) const;
    /// 8-bit sRGB, 3 channels: EXIF orientation applied, alpha composited on white; gray, 16-bit, CMYK, other profiles converted.
    virtual Raster8 read_rgb(const std::filesystem::path& file) const = 0;
    /// 16-bit, 1 channel, values as stored. Throws Error for a picture that is not 16-bit gray.
    virtual Raster16 read_depth(const std::filesystem::path& file) const = 0;
    /// PNG of 1, 3 or 4 channels. The same pixels give the same bytes.
    virtual std::vector<std::byte> encode_png(const Raster8& image) const = 0;
    virtual std::vector<std::byte> encode_png(const Raster16& image) const = 0;
    /// JPEG of 1 or 3 channels, quality 1..100.
    virtual std::vector<std::byte> encode_jpeg(const Raster8& image, int quality) const = 0;
    /// As read_rgb, but a picture with an alpha channel keeps it: 4 channels, straight alpha, nothing composited. The default
    /// calls read_rgb.
    virtual Raster8 read_with_alpha(const std::filesystem::path& file) const;
};

/// As ImageIo::read_with_alpha if the picture has transparent pixels (see least_opaque_alpha), else as ImageIo::read_rgb.
Raster8 read_picture(const ImageIo& images, const std::filesystem::path& file);

}  // namespace fresco
