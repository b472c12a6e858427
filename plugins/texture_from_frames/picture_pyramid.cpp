#include "picture_pyramid.h"

#include <fresco/texture.h>

#include <algorithm>
#include <cmath>

namespace fresco::from_frames
{

PicturePyramid::PicturePyramid(const Raster8& rgb)
{
    RasterF level(rgb.width, rgb.height, 3);
    std::transform(rgb.values.begin(), rgb.values.end(), level.values.begin(),
                   [](std::uint8_t v) { return static_cast<float>(v) / 255; });
    levels_.push_back(std::move(level));
    while (levels_.back().width > 1 && levels_.back().height > 1)
        levels_.push_back(resized(levels_.back(), levels_.back().width / 2, levels_.back().height / 2));
}

std::array<float, 3> PicturePyramid::at(double x, double y, double footprint) const
{
    const auto u = static_cast<float>(x / width());
    const auto v = static_cast<float>(1 - y / height());
    const double lod = std::clamp(std::log2(std::max(footprint, 1.0)), 0.0, static_cast<double>(levels_.size() - 1));
    const auto level = static_cast<std::size_t>(lod);
    const auto share = static_cast<float>(lod - static_cast<double>(level));
    std::array<float, 3> color{};
    sample_bilinear(levels_[level], u, v, color.data());
    if (share > 0)
    {
        std::array<float, 3> coarse{};
        sample_bilinear(levels_[level + 1], u, v, coarse.data());
        for (std::size_t c = 0; c < 3; ++c)
            color[c] += (coarse[c] - color[c]) * share;
    }
    return color;
}

}  // namespace fresco::from_frames
