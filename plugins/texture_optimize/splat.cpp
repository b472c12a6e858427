#include "splat.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace fresco::optimize
{

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
    if (camera.width != map.valid.width || camera.height != map.valid.height || camera.channels != 3 || sums_.empty())
        throw std::invalid_argument("TexelGatherer::add takes an RGB picture of the map's size");
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
