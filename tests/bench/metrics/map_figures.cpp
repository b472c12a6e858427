#include "map_figures.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bench
{

MapFigures map_figures(const fresco::UvMap& a, const fresco::UvMap& b)
{
    if (a.valid.width != b.valid.width || a.valid.height != b.valid.height)
        throw std::invalid_argument("map_figures takes maps of one size");
    MapFigures figures;
    figures.pixels = a.valid.values.size();
    std::size_t validity = 0;
    std::size_t surface = 0;
    const auto apart = [](float x, float y) { return std::abs(static_cast<double>(x) - static_cast<double>(y)); };
    for (std::size_t i = 0; i < figures.pixels; ++i)
    {
        validity += a.valid.values[i] != b.valid.values[i] ? 1 : 0;
        if (a.valid.values[i] == 0 || b.valid.values[i] == 0)
            continue;
        const double depth = apart(a.depth.values[i], b.depth.values[i]);
        if (depth > std::max(1e-3, 1e-3 * static_cast<double>(a.depth.values[i])))
        {
            ++surface;
            continue;
        }
        figures.largest_depth_m = std::max(figures.largest_depth_m, depth);
        for (const std::size_t k : {2 * i, 2 * i + 1})
            figures.largest_uv = std::max(figures.largest_uv, apart(a.uv.values[k], b.uv.values[k]));
        figures.largest_cosine = std::max(figures.largest_cosine, apart(a.cosine.values[i], b.cosine.values[i]));
    }
    const auto all = static_cast<double>(std::max<std::size_t>(figures.pixels, 1));
    figures.other_validity_share = static_cast<double>(validity) / all;
    figures.other_surface_share = static_cast<double>(surface) / all;
    return figures;
}

}  // namespace bench
