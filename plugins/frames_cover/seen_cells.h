#pragma once

#include <fresco/numerics/greedy_cover.h>
#include <fresco/uv_maps.h>

#include <vector>

namespace fresco::cover
{

/// How much it is worth to see a cell: 1 to see it at all, and more to see it well.
struct WorthRules
{
    double angle_weight;      ///< Added when it is seen straight on, in proportion to the cosine of the angle.
    double sharpness_weight;  ///< Added when the picture is sharp, in proportion to its sharpness in [0,1].
};

/// The cells that valid pixels of `map` fall into, ascending, each with the best worth that a pixel gives it, scaled so that the
/// most possible is SeenCell::best_worth; never 0. Cells are numbered row by row in a square grid of cells_px x cells_px over the
/// texture, from the lower left. \pre cells_px² <= SeenCell::most_cells, sharpness in [0,1]
std::vector<numerics::SeenCell> seen_cells(const UvMap& map, int cells_px, double sharpness, const WorthRules& rules);

}  // namespace fresco::cover
