#include "style_pictures.h"

#include <fresco/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>
#include <vector>

namespace fresco::optimize
{
namespace
{

constexpr int largest_side = 2048;
constexpr int least_side = 64;
constexpr int fine_side = 256;
constexpr int coarse_factor = 4;

RasterF opaque_rgb(const Raster8& picture)
{
    if (picture.empty() || (picture.channels != 1 && picture.channels != 3 && picture.channels != 4))
        throw Error(fmt::format("the style picture is {}x{} with {} channels; expected 1 (gray), 3 (RGB) or 4 (RGBA)",
                                picture.width, picture.height, picture.channels));
    RasterF result(picture.width, picture.height, 3);
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
        {
            const float alpha = picture.channels == 4 ? static_cast<float>(picture.at(x, y, 3)) / 255 : 1.0F;
            for (int c = 0; c < 3; ++c)
                result.at(x, y, c) =
                    static_cast<float>(picture.at(x, y, picture.channels == 1 ? 0 : c)) / 255 * alpha + (1 - alpha);
        }
    return result;
}

int scaled(int side, int to, int from)
{
    return std::max(1, static_cast<int>(std::lround(static_cast<double>(side) * to / from)));
}

/// The picture with `reference` (one of its sides, or equal to one) scaled to `to`.
RasterF with_side(const RasterF& picture, int reference, int to)
{
    return resized(picture, scaled(picture.width, to, reference), scaled(picture.height, to, reference));
}

/// Bilinear between the four nearest pixels, however much smaller it becomes.
RasterF without_antialiasing(const RasterF& picture, int width, int height)
{
    const auto place = [](int to, int to_count, int from_count)
    { return std::clamp((to + 0.5) * from_count / to_count - 0.5, 0.0, static_cast<double>(from_count - 1)); };
    RasterF result(width, height, picture.channels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
        {
            const double column = place(x, width, picture.width);
            const double row = place(y, height, picture.height);
            const int left = static_cast<int>(column);
            const int top = static_cast<int>(row);
            const int right = std::min(left + 1, picture.width - 1);
            const int bottom = std::min(top + 1, picture.height - 1);
            const auto fx = static_cast<float>(column - left);
            const auto fy = static_cast<float>(row - top);
            for (int c = 0; c < picture.channels; ++c)
                result.at(x, y, c) = (picture.at(left, top, c) * (1 - fx) + picture.at(right, top, c) * fx) * (1 - fy) +
                                     (picture.at(left, bottom, c) * (1 - fx) + picture.at(right, bottom, c) * fx) * fy;
        }
    return result;
}

StyleSizes released_sizes(RasterF source)
{
    if (std::max(source.width, source.height) > largest_side)
        source = with_side(source, std::min(source.width, source.height), largest_side);
    const int shorter = std::min(source.width, source.height);
    // Ascending: 256 px, halvings of at least 256 px, the picture as it is.
    std::vector<int> divisors{1};
    while (shorter / (2 * divisors.back()) >= fine_side)
        divisors.push_back(2 * divisors.back());
    const int divisor = divisors[divisors.size() >= 2 ? divisors.size() - 2 : 0];
    const auto fine_of = [shorter](int side) { return static_cast<int>(static_cast<double>(side) * fine_side / shorter); };
    return {without_antialiasing(source, fine_of(source.width), fine_of(source.height)),
            without_antialiasing(source, source.width / divisor, source.height / divisor)};
}

}  // namespace

StyleSizes style_sizes(const Raster8& picture, StyleRule rule, const std::function<void(const std::string&)>& message)
{
    RasterF source = opaque_rgb(picture);
    if (std::min(source.width, source.height) < least_side)
        throw Error(fmt::format("the style picture is {}x{}; expected at least {} px on the shorter side", source.width,
                                source.height, least_side));
    if (rule == StyleRule::released)
        return released_sizes(std::move(source));
    const int longer = std::max(source.width, source.height);
    if (longer > largest_side)
        source = with_side(source, longer, largest_side);
    const int shorter = std::min(source.width, source.height);
    if (shorter <= fine_side)
    {
        if (shorter < fine_side)
            message(fmt::format(
                "the style picture's shorter side has only {} px; it is used as it is ({} px or more give finer strokes)",
                shorter, fine_side));
        return {source, source};
    }
    RasterF fine = with_side(source, shorter, fine_side);
    if (fine_side * coarse_factor >= shorter)
        return {std::move(fine), std::move(source)};
    RasterF coarse = resized(source, fine.width * coarse_factor, fine.height * coarse_factor);
    return {std::move(fine), std::move(coarse)};
}

}  // namespace fresco::optimize
