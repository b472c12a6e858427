#pragma once

#include <fresco/uv_maps.h>

#include <cstddef>

namespace bench
{

/// How far two uv maps of one camera differ, whatever made them.
struct MapFigures
{
    std::size_t pixels = 0;
    double other_validity_share = 0;  ///< Of all pixels: valid in only one map.
    double other_surface_share = 0;   ///< Of all pixels: valid in both, but depths differ by more than a thousandth and 1 mm.
    double largest_uv = 0;            ///< Over the other pixels that are valid in both: the largest difference of u or v.
    double largest_depth_m = 0;
    double largest_cosine = 0;
};

/// Throws std::invalid_argument for maps of different sizes.
MapFigures map_figures(const fresco::UvMap& a, const fresco::UvMap& b);

}  // namespace bench
