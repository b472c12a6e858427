#include "color_profile.h"
#include "opencv_codec.h"
#include "picture_info.h"

#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/stage.h>

#include <fmt/format.h>
#include <utility>

namespace
{

using namespace image_opencv;

/// The key of a transparent gray on the scale that the decoder gives: fewer than 8 bits are spread over 0..255.
std::optional<std::uint16_t> decoded_key(const PictureInfo& info)
{
    if (!info.transparent_gray || info.bits >= 8)
        return info.transparent_gray;
    const unsigned greatest = (1U << static_cast<unsigned>(info.bits)) - 1;
    return static_cast<std::uint16_t>(*info.transparent_gray * 255U / greatest);
}

class OpenCvImages final : public fresco::ImageIo
{
  public:
    fresco::ImageHeader header(const std::filesystem::path& file) const override
    {
        const PictureInfo info = picture_size(file);
        return {info.width, info.height, 0, false, info.orientation};
    }

    fresco::ImageHeader check(const std::filesystem::path& file) const override
    {
        const PictureInfo info = check_picture(fresco::read_file(file), file.string(), Walk::whole);
        return {info.width, info.height, info.bits, info.is_gray, info.orientation, info.has_alpha};
    }

    fresco::Raster8 read_rgb(const std::filesystem::path& file) const override
    {
        const auto [info, picture] = read_srgb(file);
        const auto convert = [key = decoded_key(info)](const auto& raster) { return to_rgb(raster, key); };
        return oriented(std::visit(convert, picture), info.orientation);
    }

    fresco::Raster8 read_with_alpha(const std::filesystem::path& file) const override
    {
        const auto [info, picture] = read_srgb(file);
        const auto convert = [key = decoded_key(info)](const auto& raster)
        { return raster.channels == 4 || key ? to_rgba(raster, key) : to_rgb(raster); };
        return oriented(std::visit(convert, picture), info.orientation);
    }

    fresco::Raster16 read_depth(const std::filesystem::path& file) const override
    {
        auto [info, picture] = read(file);
        auto* const depth = std::get_if<fresco::Raster16>(&picture);
        if (!info.is_gray || depth == nullptr)
            throw fresco::Error(fmt::format("{}: expected a depth picture (PNG, one channel of 16 bits), found {} bits{}",
                                            file.string(), info.bits, info.is_gray ? "" : " and colors"));
        return std::move(*depth);
    }

    std::vector<std::byte> encode_png(const fresco::Raster8& image) const override { return image_opencv::encode_png(image); }
    std::vector<std::byte> encode_png(const fresco::Raster16& image) const override { return image_opencv::encode_png(image); }
    std::vector<std::byte> encode_jpeg(const fresco::Raster8& image, int quality) const override
    {
        return image_opencv::encode_jpeg(image, quality);
    }

  private:
    static std::pair<PictureInfo, DecodedPicture> read_srgb(const std::filesystem::path& file)
    {
        auto [info, picture] = read(file);
        // A key is compared with values as stored.
        if (!info.transparent_gray)
            picture = in_srgb(std::move(picture), info.profile, file.string());
        return {std::move(info), std::move(picture)};
    }

    static std::pair<PictureInfo, DecodedPicture> read(const std::filesystem::path& file)
    {
        const auto bytes = fresco::read_file(file);
        PictureInfo info = check_picture(bytes, file.string(), Walk::whole);
        auto picture = info.is_heif ? decode_heif(bytes, file.string()) : decode(bytes, file.string());
        const auto has_size = [&](const auto& raster) { return raster.width == info.width && raster.height == info.height; };
        if (!std::visit(has_size, picture))
            throw fresco::Error(file.string() +
                                ": the picture's size differs from its header: the file is damaged; copy it again");
        // The fourth byte of BMP pixels has no meaning.
        if (auto* const raster = std::get_if<fresco::Raster8>(&picture); raster != nullptr && !info.has_alpha)
            for (std::size_t i = 3; i < (raster->channels == 4 ? raster->values.size() : 0); i += 4)
                raster->values[i] = 255;
        return {std::move(info), std::move(picture)};
    }
};

}  // namespace

FRESCO_COMPONENT("image.opencv", OpenCvImages, fresco::ImageIo,
                 "PNG, JPEG, WebP, HEIC, AVIF and BMP files through OpenCV and libheif, validated before decoding")
FRESCO_LIBRARY("OpenCV", image_opencv::opencv_version())
