#pragma once

#include <fresco/geometry/flatten.h>

#include <span>
#include <vector>

/// \file From flat charts to an atlas.

namespace fresco::geometry
{

struct PackOptions
{
    int size_px;    ///< The texture for which charts share no texel.
    int gutter_px;  ///< Texels between charts at that size.
};

struct Packing
{
    std::vector<Vec2f> texcoords;  ///< 3F, in [0,1]
    double texels_per_m = 0;       ///< The same for all charts.
    double used_share = 0;         ///< Of the square: the area of all faces in it.
};

/// The turn (radians) that makes the axis-parallel box of the points smallest; 0 for fewer than three points or none apart.
double smallest_box_turn(std::vector<Vec2d> points);

/// Puts every chart into the unit square at one scale, as large as it can find: turned to its smallest box, then, largest first,
/// to the lowest and leftmost free place in one of four directions on a grid of about 1024 x 1024 cells. Throws Error if size_px
/// is too small for that many charts, and Canceled.
Packing pack_charts(const FlatCharts& flat, const PackOptions& options, Progress& progress);

}  // namespace fresco::geometry
