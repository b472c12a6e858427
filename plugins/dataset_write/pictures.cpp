#include "pictures.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/hash.h>

#include <algorithm>
#include <cmath>

using namespace fresco;

namespace
{
constexpr float millimeters = 1000;
constexpr float no_depth_from = 65534.5F;  // 65535 means none in many readers

std::string lower_extension(const std::filesystem::path& file)
{
    std::string text = file.extension().string();
    std::ranges::transform(text, text.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
}
/// 8-bit RGB, which every reader of a dataset expects: a PNG's header has both at fixed places.
bool is_plain_png(const std::vector<std::byte>& bytes)
{
    constexpr std::size_t bits_at = 24, kind_at = 25;
    return bytes.size() > kind_at && bytes[bits_at] == std::byte{8} && bytes[kind_at] == std::byte{2};
}

}  // namespace

EncodedPicture encoded_color(const Frame& frame, const Raster8& picture, const ImageIo& images)
{
    const std::string extension = lower_extension(frame.color_picture.path);
    const bool is_jpeg = extension == ".jpg" || extension == ".jpeg";
    if (!is_jpeg && extension != ".png")
        return {".png", images.encode_png(picture)};
    auto bytes = read_file(frame.color_picture.path);
    if (!frame.color_picture.hash.empty() && content_hash(bytes) != frame.color_picture.hash)
        throw Error(frame.color_picture.path.string() + ": the file changed while it was read; run again");
    if (!is_jpeg && !is_plain_png(bytes))
        return {".png", images.encode_png(picture)};
    return {is_jpeg ? ".jpg" : ".png", std::move(bytes)};
}

std::vector<std::byte> encoded_depth(const RasterF& depth, const ImageIo& images)
{
    Raster16 steps(depth.width, depth.height);
    std::ranges::transform(depth.values, steps.values.begin(),
                           [](float meters)
                           {
                               const float step = std::round(meters * millimeters);
                               return step < no_depth_from ? static_cast<std::uint16_t>(step) : std::uint16_t{0};
                           });
    return images.encode_png(steps);
}
