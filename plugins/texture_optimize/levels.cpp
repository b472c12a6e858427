#include "levels.h"

#include <algorithm>

namespace fresco::optimize
{

std::int64_t LevelPixels::count() const
{
    return std::count_if(all.values.begin(), all.values.end(), [](auto v) { return v != 0; });
}

std::vector<LevelPixels> level_pixels(std::span<const UvMap> maps)
{
    std::vector<LevelPixels> levels;
    for (const auto& map : maps)
    {
        LevelPixels pixels{map.valid, map.valid, RasterF(map.valid.width, map.valid.height)};
        std::transform(map.valid.values.begin(), map.valid.values.end(), pixels.weight.values.begin(),
                       [](auto valid) { return valid != 0 ? 1.0F : 0.0F; });
        levels.push_back(std::move(pixels));
    }
    return levels;
}

std::vector<double> level_shares(std::span<const LevelPixels> levels)
{
    std::vector<double> shares;
    double sum = 0;
    for (const auto& level : levels)
    {
        shares.push_back(level.all.empty() ? 0.0
                                           : static_cast<double>(level.count()) / static_cast<double>(level.all.values.size()));
        sum += shares.back();
    }
    for (auto& share : shares)
        share = sum > 0 ? share / sum : 0;
    return shares;
}

RasterF gradient_factor(const UvMap& map, const LevelPixels& pixels, bool by_angle)
{
    RasterF factor = pixels.weight;
    if (by_angle)
        for (std::size_t i = 0; i < factor.values.size(); ++i)
            factor.values[i] *= map.cosine.values[i];
    return factor;
}

}  // namespace fresco::optimize
