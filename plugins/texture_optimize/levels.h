#pragma once

/// \file Depth levels and the angle filter, on the CPU and without tensors: which pixels of a view belong to which height of the
/// pyramid, and the boxes around them that are encoded.

#include <fresco/image.h>
#include <fresco/uv_maps.h>

#include <span>
#include <vector>

namespace fresco::optimize
{

/// Where StyleMesh's paper and its authors' released code differ. Nobody mixes them, so it is one option.
enum class Protocol
{
    paper,
    /// The stored values of each layer are clamped after every step, the sum of the layers never. ŵ_l of a term comes from the
    /// masks on its layer's grid. An angle passes the filter if it is below the limit, and angles are those of the smallest
    /// height, enlarged. The camera is encoded at the smallest height and its features are enlarged. Pixels without a surface
    /// show the texture's first texel. The style's sizes are the authors' (style_sizes). The views are visited in recorded order,
    /// and the last hundredth of them not at all.
    released
};

/// θ_min of StyleMesh, section 3.2: what θ_d meters at a distance of 1 m should be at least, in pixels of height.
inline constexpr double theta_min_px = 32;

/// The two heights of one depth, as indices; `second == first` and weight 1 where only one takes part.
struct LevelChoice
{
    std::size_t first = 0;
    std::size_t second = 0;
    double first_weight = 1;  ///< The second's is the rest.
};

/// Ideal height R = θ_min d / θ_d; the nearest height first (the lower of two as near), the next one on R's other side second.
/// Where R lies the share t of the way to the second, the first has the weight 1 - t: the formula that the paper prints would
/// give 0 at an exact hit. `heights_px`: ascending, not empty. `theta_d_m`: θ_d, smaller for scans of short range.
LevelChoice level_choice(double depth_m, std::span<const int> heights_px, double theta_d_m);

/// Which pixels take part in the fine style loss (StyleMesh, section 3.3).
struct AngleRule
{
    double limit_deg;  ///< Largest angle between normal and view that passes, of each height's own map.
    /// Released: the limit itself does not pass; angles of the smallest height, enlarged bilinearly, cosines alike.
    Protocol protocol;
};

/// The pixels of one rendered height that take part.
struct LevelPixels
{
    Raster8 all;                 ///< H x W: 1 = belongs to the level.
    Raster8 fine;                ///< H x W: 1 = also passes the angle filter.
    RasterF weight;              ///< H x W: share of the level in the pixel, [0,1]; 0 outside `all`.
    RasterF cosine;              ///< H x W: cos α that the scaling uses; empty: the uv map's own.
    std::int64_t count() const;  ///< Pixels in `all`.
};

/// Without depth levels: every valid pixel belongs to every height with weight 1. `maps`: one per height, ascending.
std::vector<LevelPixels> whole_levels(std::span<const UvMap> maps, const AngleRule& angle);

/// With depth levels. Assignment, weights and the 3x3 erosion (outside the picture is background) are computed on the smallest
/// height and resampled by nearest neighbor; a mask is eroded after the union of its two roles, weights per role. Pixels that
/// are invalid at their own height are left out.
/// \param depth  of the smallest height's pixels in meters, 0 = belongs to no level; usually maps[0].depth
std::vector<LevelPixels> depth_levels(std::span<const UvMap> maps, const RasterF& depth, double theta_d_m,
                                      const AngleRule& angle);

/// ŵ_l of StyleMesh, section 3.4: the covered share of each level, divided by the sum of the shares; all zero without any pixel.
std::vector<double> level_shares(std::span<const LevelPixels> levels);

/// What image gradients are multiplied by (StyleMesh, section 3.5).
enum class GradientScaling
{
    none,   ///< 1 in the level.
    level,  ///< The level's share in the pixel.
    angle   ///< The level's share times cos α.
};

/// 0 outside the level.
RasterF gradient_factor(const UvMap& map, const LevelPixels& pixels, GradientScaling scaling);

/// 1 where `mask` and its eight neighbors are 1; outside the raster is 0.
Raster8 eroded(const Raster8& mask);

/// Pixels [x0, x1) x [y0, y1).
struct PixelBox
{
    int x0 = 0;
    int y0 = 0;
    int x1 = 0;
    int y1 = 0;
    std::int64_t area() const { return static_cast<std::int64_t>(x1 - x0) * (y1 - y0); }
    friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

/// A part of a frame that is encoded by itself.
struct Crop
{
    PixelBox core;     ///< Whose features are used.
    PixelBox encoded;  ///< The core and the pixels that its features see.
};

/// Crops whose cores are disjoint and together hold every pixel of `mask`; one of the whole frame where crops would save less
/// than a tenth of its pixels, none for an empty mask. Boxes begin at multiples of `align` and end there or at the frame's
/// border, so that a network whose strides divide `align` gives in a crop's core what it gives in the whole frame. \param
/// margin_px  pixels beyond its own cell that a feature sees
std::vector<Crop> covering_crops(const Raster8& mask, int align, int margin_px);

}  // namespace fresco::optimize
