#include "npy_image.h"

#include <fresco/error.h>
#include <fresco/npy.h>

#include <fmt/format.h>
#include <string>

namespace read_image
{
namespace
{

constexpr std::size_t max_pixels = 300'000'000;

std::string text_of(const std::vector<std::size_t>& shape)
{
    return shape.empty() ? "()" : fmt::format("{}", fmt::join(shape, " x "));
}

}  // namespace

fresco::Image image_from_npy(const std::filesystem::path& file)
{
    const fresco::NpyArray array = fresco::read_npy(file);
    const auto& shape = array.shape;
    const std::size_t channels = shape.size() == 3 ? shape[2] : 1;
    if (array.type != fresco::NpyType::uint8 || (shape.size() != 2 && shape.size() != 3) ||
        (channels != 1 && channels != 3 && channels != 4))
        throw fresco::Error(file.string() + ": expected a picture, uint8 of height x width x 3 (or 1, or 4); found " +
                            text_of(shape) + (array.type == fresco::NpyType::uint8 ? "" : " of a different type"));
    if (shape[0] == 0 || shape[1] == 0 || shape[0] > max_pixels / shape[1])
        throw fresco::Error(file.string() + ": a picture of " + text_of(shape) + "; expected 1 to 200 million pixels");
    fresco::Raster8 pixels;
    pixels.height = static_cast<int>(shape[0]);
    pixels.width = static_cast<int>(shape[1]);
    pixels.channels = static_cast<int>(channels);
    const auto values = array.as<std::uint8_t>();
    pixels.values.assign(values.begin(), values.end());
    return fresco::Image(std::move(pixels));
}

}  // namespace read_image
