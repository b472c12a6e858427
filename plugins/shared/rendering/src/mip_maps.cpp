#include <fresco/error.h>
#include <fresco/numerics/bilinear.h>
#include <fresco/numerics/wide_vectors.h>
#include <fresco/rendering/mip_maps.h>

#include <algorithm>
#include <cstring>
#include <fmt/format.h>

namespace fresco::rendering
{

namespace
{
constexpr float steps_per_unit = 4;  // 255 becomes 1020 of 1023
constexpr int bits = 10;
constexpr std::uint32_t mask = (1U << bits) - 1;

std::uint32_t packed(const float* rgb)
{
    std::uint32_t texel = 0;
    for (int c = 0; c < 3; ++c)
        texel |= static_cast<std::uint32_t>(std::clamp(rgb[c] * steps_per_unit + 0.5F, 0.0F, 1020.0F)) << (bits * c);
    return texel;
}

RasterF halved(const RasterF& level)
{
    return resized(level, std::max(1, level.width / 2), std::max(1, level.height / 2));
}

/// Halves a picture: one with even sides, such as any large texture, is never held as floats, which take four times its
/// size.
RasterF halved(const Raster8& picture)
{
    if (picture.width % 2 != 0 || picture.height % 2 != 0)
    {
        RasterF level(picture.width, picture.height, 3);
        std::copy(picture.values.begin(), picture.values.end(), level.values.begin());
        return halved(level);
    }
    RasterF result(picture.width / 2, picture.height / 2, 3);
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
            for (int c = 0; c < 3; ++c)
            {
                const auto sum = [&](int row) { return picture.at(2 * x, row, c) + picture.at(2 * x + 1, row, c); };
                result.at(x, y, c) = static_cast<float>(sum(2 * y) + sum(2 * y + 1)) / 4;
            }
    return result;
}

}  // namespace

MipMaps::MipMaps(const Raster8& picture, TextureFilter filter)
{
    if (picture.channels != 3 || picture.empty())
        throw Error(fmt::format("the picture has {} channels; expected 3 (RGB)", picture.channels));
    const std::size_t full = picture.values.size() / 3;
    texels_.reserve(filter == TextureFilter::bilinear ? full : full + full / 3 + 64);
    levels_.push_back({picture.width, picture.height, 0, 1, 1});
    for (std::size_t texel = 0; texel < full; ++texel)
    {
        std::array<float, 3> rgb;
        std::copy_n(&picture.values[3 * texel], 3, rgb.begin());
        texels_.push_back(packed(rgb.data()));
    }
    if (filter == TextureFilter::bilinear || (picture.width == 1 && picture.height == 1))
        return;
    RasterF level = halved(picture);
    add_level(level);
    while (level.width > 1 || level.height > 1)
    {
        level = halved(level);
        add_level(level);
    }
}

void MipMaps::add_level(const RasterF& colors)
{
    levels_.push_back({colors.width, colors.height, static_cast<std::int32_t>(texels_.size()),
                       static_cast<double>(colors.width) / width(), static_cast<double>(colors.height) / height()});
    for (std::size_t value = 0; value < colors.values.size(); value += 3)
        texels_.push_back(packed(&colors.values[value]));
}

Vec3d MipMaps::sample_level(Vec2d uv, const Level& level) const
{
    return numerics::bilinear(numerics::between<double>(uv.x * level.width - 0.5, level.width),
                              numerics::between<double>((1 - uv.y) * level.height - 0.5, level.height),
                              [&](int x, int y)
                              {
                                  const std::uint32_t texel =
                                      texels_[static_cast<std::size_t>(level.first + y * level.width + x)];
                                  return Vec3d{double(texel & mask), double(texel >> bits & mask), double(texel >> 2 * bits)} *
                                         (1 / double{steps_per_unit});
                              });
}

Vec3d MipMaps::sample(Vec2d uv, double lod) const
{
    const double at = std::clamp(lod, 0.0, static_cast<double>(levels_.size() - 1));
    const auto level = static_cast<std::size_t>(at);
    const double share = at - static_cast<double>(level);
    const Vec3d fine = sample_level(uv, levels_[level]);
    return share > 0 ? fine * (1 - share) + sample_level(uv, levels_[level + 1]) * share : fine;
}

using namespace numerics::wide_vectors;

void Lookups::start(std::size_t most)
{
    count_ = 0;
    // Two levels each, and the last lanes.
    if (const std::size_t places = 2 * most + lanes; places > x_.size())
    {
        for (auto* numbers : {&x_, &y_, &weights_, &colors_[0], &colors_[1], &colors_[2]})
            numbers->resize(places);
        // A level of one texel: the last lanes look something up, too.
        firsts_.resize(places);
        widths_.resize(places, 1);
        heights_.resize(places, 1);
    }
}

void Lookups::add_smaller(double u, double v, double lod, float weight)
{
    const double at = std::min(lod, static_cast<double>(maps_.levels_.size() - 1));
    const auto number = static_cast<std::size_t>(at);
    const auto share = static_cast<float>(at - static_cast<double>(number));
    const auto add_of = [&](std::size_t level, float part)
    {
        const MipMaps::Level& to = maps_.levels_[level];
        add_place(u * to.scale_x - 0.5, to.height - 0.5 - v * to.scale_y, weight * part, to);
    };
    add_of(number, 1 - share);
    if (share > 0)
        add_of(number + 1, share);
}

FRESCO_WIDE_VECTORS void Lookups::look_up()
{
    const std::uint32_t* texels = maps_.texels_.data();
    // The last lanes look up what they held before, which may be of any level.
    for (std::size_t i = 0; i < count_; i += lanes)
    {
        const auto load = [i](auto& vector, const auto& numbers) { std::memcpy(&vector, &numbers[i], sizeof vector); };
        Floats x, y, weight;
        load(x, x_);
        load(y, y_);
        load(weight, weights_);
        Ints first, width, height;
        load(first, firsts_);
        load(width, widths_);
        load(height, heights_);
        const Ints last_x = width - 1;
        const Ints last_y = height - 1;
        const Floats right = __builtin_convertvector(last_x, Floats);
        const Floats bottom = __builtin_convertvector(last_y, Floats);
        x = x > 0 ? x : Floats{};
        y = y > 0 ? y : Floats{};
        x = x < right ? x : right;
        y = y < bottom ? y : bottom;
        const Ints column = __builtin_convertvector(x, Ints);
        const Ints row = __builtin_convertvector(y, Ints);
        x -= __builtin_convertvector(column, Floats);
        y -= __builtin_convertvector(row, Floats);
        // A comparison that holds is -1.
        const Ints upper_left = first + row * width + column;
        const Ints upper_right = upper_left - (column < last_x);
        const Ints down = width & (row < last_y);
        const Ints lower_left = upper_left + down;
        const Ints lower_right = upper_right + down;
        Ints a, b, c, d;
        for (std::size_t lane = 0; lane < lanes; ++lane)
        {
            const auto at = [&](const Ints& texel) { return static_cast<std::int32_t>(texels[texel[lane]]); };
            a[lane] = at(upper_left);
            b[lane] = at(upper_right);
            c[lane] = at(lower_left);
            d[lane] = at(lower_right);
        }
        weight *= 1 / steps_per_unit;
        for (int channel = 0; channel < 3; ++channel)
        {
            const auto value = [channel](const Ints& texel, Floats& out)
            { out = __builtin_convertvector(texel >> (bits * channel) & static_cast<std::int32_t>(mask), Floats); };
            Floats upper, to, lower, lower_to;
            value(a, upper);
            value(b, to);
            value(c, lower);
            value(d, lower_to);
            upper += (to - upper) * x;
            lower += (lower_to - lower) * x;
            const Floats color = (upper + (lower - upper) * y) * weight;
            std::memcpy(&colors_[static_cast<std::size_t>(channel)][i], &color, sizeof color);
        }
    }
}

}  // namespace fresco::rendering
