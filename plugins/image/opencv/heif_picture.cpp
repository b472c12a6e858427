#include "color_profile.h"
#include "opencv_codec.h"
#include "picture_bytes.h"
#include "picture_info.h"

#include <libheif/heif.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

namespace image_opencv
{
namespace
{

using HeifContext = std::unique_ptr<heif_context, Closing<heif_context_free>>;
using HeifHandle = std::unique_ptr<heif_image_handle, Closing<heif_image_handle_release>>;
using HeifImage = std::unique_ptr<heif_image, Closing<heif_image_release>>;
using HeifOptions = std::unique_ptr<heif_decoding_options, Closing<heif_decoding_options_free>>;
using HeifColors = std::unique_ptr<heif_color_profile_nclx, Closing<heif_nclx_color_profile_free>>;

[[noreturn]] void fail_heif(std::string_view source, const std::string& what)
{
    throw fresco::Error(fmt::format("{}: {}", source, what));
}

void expect_good(const heif_error& error, std::string_view source)
{
    if (error.code == heif_error_Ok)
        return;
    std::string reason = error.message == nullptr ? "" : error.message;
    reason.resize(reason.find_last_not_of(" \n") + 1);
    const std::string what = fmt::format("libheif cannot read the picture ({})", reason);
    if (error.code == heif_error_Unsupported_feature || error.code == heif_error_Plugin_loading_error ||
        error.code == heif_error_Decoder_plugin_error)
        fail_heif(source,
                  what +
                      "; if its decoder is missing, install libheif-plugin-libde265 (HEIC) and libheif-plugin-dav1d (AVIF), or "
                      "convert the picture to PNG or JPEG");
    fail_heif(source, what + ": it is damaged, or of a kind that is not supported; copy it again, or convert it to PNG or JPEG");
}

/// The boxes of the file (ISO/IEC 14496-12): all inside of it, one of them the index, one the data.
void check_boxes(const PictureBytes& file)
{
    bool has_index = false;
    bool has_data = false;
    for (std::size_t at = 0; at < file.size();)
    {
        std::uint64_t length = file.u32(at);
        std::size_t header = 8;
        if (length == 1)
        {
            length = std::uint64_t{file.u32(at + 8)} << 32U | file.u32(at + 12);
            header = 16;
        }
        else if (length == 0)
            length = file.size() - at;
        if (length < header)
            file.fail(at, fmt::format("a box of {} bytes: the file is damaged", length));
        const auto box = file.part(at, length);
        has_index = has_index || file.has(at + 4, "meta");
        // A small picture may lie in the index.
        constexpr std::array inside{std::byte{'i'}, std::byte{'d'}, std::byte{'a'}, std::byte{'t'}};
        has_data =
            has_data || file.has(at + 4, "mdat") || (file.has(at + 4, "meta") && !std::ranges::search(box, inside).empty());
        at += length;
    }
    if (!has_index)
        file.fail(file.size(), "the file has no index of pictures (box meta): it is truncated, or a film");
    if (!has_data)
        file.fail(file.size(), "the file ends before its pictures (box mdat): it is truncated");
}

/// The file's main picture; `context` holds it.
HeifHandle opened(const HeifContext& context, std::span<const std::byte> bytes, std::string_view source)
{
    expect_good(heif_context_read_from_memory_without_copy(context.get(), bytes.data(), bytes.size(), nullptr), source);
    heif_image_handle* handle = nullptr;
    expect_good(heif_context_get_primary_image_handle(context.get(), &handle), source);
    return HeifHandle(handle);
}

/// As ICC, of colors that the file names by numbers (ISO/IEC 23091-2); empty: sRGB.
std::vector<std::byte> named_profile(const heif_image_handle* picture, std::string_view source)
{
    heif_color_profile_nclx* found = nullptr;
    if (heif_image_handle_get_nclx_color_profile(picture, &found).code != heif_error_Ok || found == nullptr)
        return {};
    const HeifColors nclx(found);
    double gamma = 0;
    switch (nclx->transfer_characteristics)
    {
    case heif_transfer_characteristic_ITU_R_BT_2100_0_PQ:
    case heif_transfer_characteristic_ITU_R_BT_2100_0_HLG:
        fail_heif(source, "a picture of high dynamic range (PQ or HLG); convert it to sRGB");
    case heif_transfer_characteristic_ITU_R_BT_470_6_System_M:
        gamma = 2.2;
        break;
    case heif_transfer_characteristic_ITU_R_BT_470_6_System_B_G:
        gamma = 2.8;
        break;
    case heif_transfer_characteristic_linear:
        gamma = 1;
        break;
    default:
        // Video profiles are written beside pictures that every program shows as sRGB.
        break;
    }
    const bool is_srgb =
        nclx->color_primaries == heif_color_primaries_ITU_R_BT_709_5 || nclx->color_primaries == heif_color_primaries_unspecified;
    if (is_srgb && gamma == 0)
        return {};
    if (nclx->color_primaries == heif_color_primaries_unspecified)
        heif_nclx_color_profile_set_color_primaries(nclx.get(), heif_color_primaries_ITU_R_BT_709_5);
    return icc_of_primaries({nclx->color_primary_red_x, nclx->color_primary_red_y, nclx->color_primary_green_x,
                             nclx->color_primary_green_y, nclx->color_primary_blue_x, nclx->color_primary_blue_y,
                             nclx->color_primary_white_x, nclx->color_primary_white_y},
                            gamma, source);
}

std::vector<std::byte> profile_of(const heif_image_handle* picture, std::string_view source)
{
    std::vector<std::byte> icc(heif_image_handle_get_raw_color_profile_size(picture));
    if (icc.empty())
        return named_profile(picture, source);
    expect_good(heif_image_handle_get_raw_color_profile(picture, icc.data()), source);
    return icc;
}

/// `stride`: bytes of a row. `bits`: of the values; 16-bit numbers are little-endian.
template <class T>
fresco::Raster<T> raster_of_rows(const std::uint8_t* rows, int stride, int bits, int width, int height, int channels)
{
    fresco::Raster<T> raster(width, height, channels);
    const std::uint32_t greatest = (1U << static_cast<unsigned>(bits)) - 1;
    for (int y = 0; y < height; ++y)
    {
        T* const row = &raster.values[raster.index(0, y)];
        const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(channels);
        std::memcpy(row, rows + static_cast<std::ptrdiff_t>(y) * stride, count * sizeof(T));
        for (std::size_t i = 0; sizeof(T) > 1 && i < count; ++i)
            row[i] = static_cast<T>((std::min<std::uint32_t>(row[i], greatest) * 0xFFFFU + greatest / 2) / greatest);
    }
    return raster;
}

}  // namespace

PictureInfo check_heif(std::span<const std::byte> bytes, std::string_view source, Walk walk)
{
    const PictureBytes file(bytes, source);
    check_boxes(file);
    const HeifContext context(heif_context_alloc());
    const HeifHandle picture = opened(context, bytes, source);
    PictureInfo info;
    info.is_heif = true;
    file.take_size(info, 0, heif_image_handle_get_width(picture.get()), heif_image_handle_get_height(picture.get()));
    info.has_alpha = heif_image_handle_has_alpha_channel(picture.get()) != 0;
    info.bits = heif_image_handle_get_luma_bits_per_pixel(picture.get());
    if (walk == Walk::whole)
        info.profile = profile_of(picture.get(), source);
    return info;
}

DecodedPicture decode_heif(std::span<const std::byte> bytes, std::string_view source)
{
    const HeifContext context(heif_context_alloc());
    const HeifHandle picture = opened(context, bytes, source);
    const bool has_alpha = heif_image_handle_has_alpha_channel(picture.get()) != 0;
    const bool is_deep = heif_image_handle_get_luma_bits_per_pixel(picture.get()) > 8;
    const HeifOptions options(heif_decoding_options_alloc());
    options->strict_decoding = 1;
    const heif_chroma deep = has_alpha ? heif_chroma_interleaved_RRGGBBAA_LE : heif_chroma_interleaved_RRGGBB_LE;
    const heif_chroma plain = has_alpha ? heif_chroma_interleaved_RGBA : heif_chroma_interleaved_RGB;
    heif_image* decoded = nullptr;
    expect_good(heif_decode_image(picture.get(), &decoded, heif_colorspace_RGB, is_deep ? deep : plain, options.get()), source);
    const HeifImage image(decoded);
    int stride = 0;
    const std::uint8_t* const rows = heif_image_get_plane_readonly(image.get(), heif_channel_interleaved, &stride);
    if (rows == nullptr)
        fail_heif(source, "libheif decoded no colors: the picture is damaged");
    const int width = heif_image_get_width(image.get(), heif_channel_interleaved);
    const int height = heif_image_get_height(image.get(), heif_channel_interleaved);
    const int bits = heif_image_get_bits_per_pixel_range(image.get(), heif_channel_interleaved);
    const int channels = has_alpha ? 4 : 3;
    if (is_deep)
        return raster_of_rows<std::uint16_t>(rows, stride, bits, width, height, channels);
    return raster_of_rows<std::uint8_t>(rows, stride, bits, width, height, channels);
}

}  // namespace image_opencv
