#pragma once

#include <fresco/uv_maps.h>

#include <span>
#include <vector>

namespace fresco::optimize
{

/// The pixels of one rendered height that take part.
struct LevelPixels
{
    Raster8 all;                 ///< H x W: 1 = belongs to the level.
    Raster8 fine;                ///< H x W: 1 = also takes part in the fine style loss.
    RasterF weight;              ///< H x W: factor of the image gradient; 0 outside `all`.
    std::int64_t count() const;  ///< Pixels in `all`.
};

/// One entry per height: every valid pixel belongs to every level with weight 1 and takes part in the fine loss.
std::vector<LevelPixels> level_pixels(std::span<const UvMap> maps);

/// ŵ_l of METHOD section 5: the covered share of each level, divided by the sum of the shares; all zero without any pixel.
std::vector<double> level_shares(std::span<const LevelPixels> levels);

/// What the image gradient of a level is multiplied by (METHOD section 6): the level's weight, and with `by_angle` cos α.
RasterF gradient_factor(const UvMap& map, const LevelPixels& pixels, bool by_angle);

}  // namespace fresco::optimize
