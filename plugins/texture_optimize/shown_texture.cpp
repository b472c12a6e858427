#include "shown_texture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace fresco::optimize
{
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

}  // namespace fresco::optimize
