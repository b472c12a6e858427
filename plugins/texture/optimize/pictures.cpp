#include "pictures.h"

#include <fresco/error.h>
#include <fresco/image_io.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/numerics/noise.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace fresco::optimize
{
namespace
{
/// Means of red, green and blue.
constexpr std::array<float, 3> network_mean{123.68F, 116.779F, 103.939F};
}  // namespace

std::pair<double, double> ValueSpace::stored_range() const
{
    if (!network_)
        return {0, 1};
    return {-static_cast<double>(network_mean[0]), 255 - static_cast<double>(network_mean[2])};
}

float ValueSpace::offset(std::size_t channel) const
{
    return network_ ? network_mean.at(channel) : 0.0F;
}

void ValueSpace::store(RasterF& picture) const
{
    if (!network_)
        return;
    for (std::size_t i = 0; i + 2 < picture.values.size(); i += 3)
    {
        std::swap(picture.values[i], picture.values[i + 2]);
        for (std::size_t k = 0; k < 3; ++k)
            picture.values[i + k] = picture.values[i + k] * 255 - network_mean[2 - k];
    }
}

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
            if (picture.channels == 4 && picture.at(x, y, 3) < least_opaque_alpha)
                throw Error("the style picture has transparent pixels, whose colors are unknown, and losses compare it as a "
                            "whole: cut out an opaque part, or paint with texture.synthesize, which copies opaque parts only");
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
    { return numerics::between<float>((to + 0.5) * from_count / to_count - 0.5, from_count); };
    RasterF result(width, height, picture.channels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < picture.channels; ++c)
                result.at(x, y, c) = numerics::bilinear(place(x, width, picture.width), place(y, height, picture.height),
                                                        [&](int column, int row) { return picture.at(column, row, c); });
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

StyleSizes style_sizes(const Raster8& picture, Protocol protocol, const std::function<void(const std::string&)>& message)
{
    RasterF source = opaque_rgb(picture);
    if (std::min(source.width, source.height) < least_side)
        throw Error(fmt::format("the style picture is {}x{}; expected at least {} px on the shorter side", source.width,
                                source.height, least_side));
    if (is_released(protocol))
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

namespace
{

constexpr std::uint32_t first_octave = 2;
constexpr std::uint32_t octaves = 5;

/// In [0,1]; the mean is 1/2.
float corner(std::uint32_t x, std::uint32_t y, std::uint32_t key)
{
    return noise::unit(noise::hash(x, y), key);
}

float octave(std::uint32_t x, std::uint32_t y, std::uint32_t shift, std::uint32_t key)
{
    const auto cell = static_cast<float>(1U << shift);
    const std::uint32_t left = x >> shift;
    const std::uint32_t top = y >> shift;
    const float u = (static_cast<float>(x - (left << shift)) + 0.5F) / cell;
    const float v = (static_cast<float>(y - (top << shift)) + 0.5F) / cell;
    const float upper = (1 - u) * corner(left, top, key) + u * corner(left + 1, top, key);
    const float lower = (1 - u) * corner(left, top + 1, key) + u * corner(left + 1, top + 1, key);
    return (1 - v) * upper + v * lower;
}

}  // namespace

RasterF noise_picture(int size_px, Vec3d mean, Vec3d deviation, std::uint64_t seed, int threads)
{
    // A corner's variance is 1/12; between corners, over a cell, 4/9 of it is left.
    const double one = std::sqrt(octaves * (1.0 / 12) * (4.0 / 9));
    const std::array<double, 3> means{mean.x, mean.y, mean.z};
    const std::array<double, 3> deviations{deviation.x / one, deviation.y / one, deviation.z / one};
    const auto size = static_cast<std::size_t>(size_px);
    const auto key = static_cast<std::uint32_t>(seed ^ (seed >> 32U));
    RasterF picture(size_px, size_px, 3);
    parallel_for(size, 64, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t y = begin; y < end; ++y)
                         for (std::size_t i = 0; i < 3 * size; ++i)
                         {
                             const auto channel = static_cast<std::uint32_t>(i % 3);
                             double sum = -0.5 * octaves;
                             for (std::uint32_t o = 0; o < octaves; ++o)
                                 sum +=
                                     static_cast<double>(octave(static_cast<std::uint32_t>(i / 3), static_cast<std::uint32_t>(y),
                                                                first_octave + o, noise::hash(key, 8 * o + channel)));
                             picture.values[y * 3 * size + i] =
                                 static_cast<float>(std::clamp(means[channel] + deviations[channel] * sum, 0.0, 1.0));
                         }
                 });
    return picture;
}

namespace
{

constexpr int smallest_px = 16;

/// How far, in shares of the texture, the nearer of the neighbors (x ± dx, y ± dy) is: the other may be in another chart.
float to_neighbor(const UvMap& map, int x, int y, int dx, int dy)
{
    float least = std::numeric_limits<float>::infinity();
    for (const int side : {-1, 1})
    {
        const int nx = x + side * dx;
        const int ny = y + side * dy;
        if (nx < 0 || ny < 0 || nx >= map.valid.width || ny >= map.valid.height || map.valid.at(nx, ny) == 0)
            continue;
        least = std::min(least, std::hypot(map.uv.at(nx, ny, 0) - map.uv.at(x, y, 0), map.uv.at(nx, ny, 1) - map.uv.at(x, y, 1)));
    }
    return least;
}

}  // namespace

RasterF displayed(const Texture& texture)
{
    RasterF sum = texture.layers.front();
    for (std::size_t i = 1; i < texture.layers.size(); ++i)
    {
        const RasterF layer = resized(texture.layers[i], sum.width, sum.height);
        std::transform(sum.values.begin(), sum.values.end(), layer.values.begin(), sum.values.begin(), std::plus<>());
    }
    for (float& value : sum.values)
        value = std::clamp(value, 0.0F, 1.0F);
    return sum;
}

ShownTexture::ShownTexture(const Texture& texture)
{
    sizes_.push_back(displayed(texture));
    while (sizes_.back().width >= 2 * smallest_px)
        sizes_.push_back(resized(sizes_.back(), sizes_.back().width / 2, sizes_.back().height / 2));
}

Raster8 ShownTexture::shown(const UvMap& map) const
{
    Raster8 picture(map.valid.width, map.valid.height, 3);
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
        {
            if (map.valid.at(x, y) == 0)
                continue;
            float apart = std::max(to_neighbor(map, x, y, 1, 0), to_neighbor(map, x, y, 0, 1));
            if (!std::isfinite(apart))
                apart = 0;
            std::size_t size = 0;
            while (size + 1 < sizes_.size() && apart * static_cast<float>(sizes_[size].width) > 1.5F)
                ++size;
            float color[3];
            sample_bilinear(sizes_[size], map.uv.at(x, y, 0), map.uv.at(x, y, 1), color);
            for (int c = 0; c < 3; ++c)
                picture.at(x, y, c) = static_cast<std::uint8_t>(std::lround(255 * color[c]));
        }
    return picture;
}

TexelGatherer::TexelGatherer(int size_px, bool with_colors) : size_(size_px), seen_(size_px, size_px)
{
    if (with_colors)
        sums_ = RasterF(size_px, size_px, 4);
}

/// Calls visit(pixel number, texel number, bilinear weight) for each weight above zero.
template <class Visit>
void TexelGatherer::each_texel(const UvMap& map, const Visit& visit)
{
    const auto last = static_cast<float>(size_ - 1);
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
    {
        if (map.valid.values[i] == 0)
            continue;
        const float x = std::clamp(map.uv.values[2 * i] * static_cast<float>(size_) - 0.5F, 0.0F, last);
        const float y = std::clamp((1 - map.uv.values[2 * i + 1]) * static_cast<float>(size_) - 0.5F, 0.0F, last);
        const int column = static_cast<int>(x);
        const int row = static_cast<int>(y);
        const float right = x - static_cast<float>(column);
        const float down = y - static_cast<float>(row);
        for (int dy = 0; dy < 2; ++dy)
            for (int dx = 0; dx < 2; ++dx)
            {
                const float weight = (dx == 0 ? 1 - right : right) * (dy == 0 ? 1 - down : down);
                if (weight > 0)
                    visit(i, seen_.index(column + dx, row + dy), weight);
            }
    }
}

void TexelGatherer::mark(const UvMap& map)
{
    each_texel(map, [this](std::size_t, std::size_t texel, float) { seen_.values[texel] = 1; });
}

void TexelGatherer::add(const UvMap& map, const RasterF& camera)
{
    each_texel(map,
               [&](std::size_t pixel, std::size_t texel, float weight)
               {
                   seen_.values[texel] = 1;
                   const float depth = map.depth.values[pixel];
                   if (!(depth > 0))
                       return;
                   const float share = weight * map.cosine.values[pixel] / depth;
                   for (std::size_t c = 0; c < 3; ++c)
                       sums_.values[4 * texel + c] += share * camera.values[3 * pixel + c];
                   sums_.values[4 * texel + 3] += share;
               });
}

RasterF TexelGatherer::take_colors(Raster8& covered)
{
    RasterF colors(size_, size_, 3);
    covered = Raster8(size_, size_);
    for (std::size_t i = 0; i < covered.values.size(); ++i)
    {
        const float weight = sums_.values[4 * i + 3];
        // Below this a texel was only grazed: its color is better filled in from its neighbors.
        if (!(weight > 1e-6F))
            continue;
        covered.values[i] = 1;
        for (std::size_t c = 0; c < 3; ++c)
            colors.values[3 * i + c] = sums_.values[4 * i + c] / weight;
    }
    sums_ = {};
    return colors;
}

}  // namespace fresco::optimize
