#include <fresco/raycast/mip_maps.h>

#include <fresco/error.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace fresco::raycast
{

namespace
{
constexpr float steps_per_unit = 257;  // 255 becomes 65535

Raster16 stored(const RasterF& values)
{
    Raster16 result(values.width, values.height, 3);
    std::transform(values.values.begin(), values.values.end(), result.values.begin(),
                   [](float v) { return static_cast<std::uint16_t>(std::clamp(v * steps_per_unit + 0.5F, 0.0F, 65535.0F)); });
    return result;
}

RasterF halved(const RasterF& level)
{
    return resized(level, std::max(1, level.width / 2), std::max(1, level.height / 2));
}

/// The same of a picture: one with even sides, such as any large texture, is never held as floats, which take four times its
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

/// Bilinear, in the raster's own steps.
template <class T>
Vec3d sampled(const Raster<T>& texels, Vec2d uv)
{
    const double x = std::clamp(uv.x * texels.width - 0.5, 0.0, texels.width - 1.0);
    const double y = std::clamp((1 - uv.y) * texels.height - 0.5, 0.0, texels.height - 1.0);
    const int x0 = static_cast<int>(x);
    const int y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, texels.width - 1);
    const int y1 = std::min(y0 + 1, texels.height - 1);
    const auto texel = [&](int tx, int ty)
    {
        const T* rgb = &texels.at(tx, ty);
        return Vec3d{double(rgb[0]), double(rgb[1]), double(rgb[2])};
    };
    const Vec3d top = texel(x0, y0) * (x0 + 1 - x) + texel(x1, y0) * (x - x0);
    const Vec3d bottom = texel(x0, y1) * (x0 + 1 - x) + texel(x1, y1) * (x - x0);
    return top * (y0 + 1 - y) + bottom * (y - y0);
}
}  // namespace

MipMaps::MipMaps(Raster8 picture, bool smaller_levels) : picture_(std::move(picture))
{
    if (picture_.channels != 3 || picture_.empty())
        throw Error(fmt::format("the picture has {} channels; expected 3 (RGB)", picture_.channels));
    if (!smaller_levels || (picture_.width == 1 && picture_.height == 1))
        return;
    RasterF level = halved(picture_);
    smaller_.push_back(stored(level));
    while (level.width > 1 || level.height > 1)
    {
        level = halved(level);
        smaller_.push_back(stored(level));
    }
}

Vec3d MipMaps::sample_level(Vec2d uv, std::size_t level) const
{
    return level == 0 ? sampled(picture_, uv) : sampled(smaller_[level - 1], uv) * (1.0 / double{steps_per_unit});
}

Vec3d MipMaps::sample(Vec2d uv, double lod) const
{
    const double at = std::clamp(lod, 0.0, static_cast<double>(smaller_.size()));
    const auto level = static_cast<std::size_t>(at);
    const double share = at - static_cast<double>(level);
    const Vec3d fine = sample_level(uv, level);
    return share > 0 ? fine * (1 - share) + sample_level(uv, level + 1) * share : fine;
}

}  // namespace fresco::raycast
