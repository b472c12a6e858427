#pragma once

/// \file Depth levels and the angle filter, on the CPU and without tensors: which pixels of a view belong to which height of the
/// pyramid, and the boxes around them that are encoded.

#include <fresco/image.h>
#include <fresco/uv_maps.h>

#include <span>
#include <vector>

namespace fresco::optimize
{

/// Differences between StyleMesh's paper and its authors' released code, chosen together. The released code:
/// - reads views as released_view() does; its levels have the pixels of the largest map's surface, resampled, and a level's
/// pixels
///   without a surface of their own show the texture's first texel and pull at it;
/// - resamples masks by the upper left corners of pixels and cells, not by their centers;
/// - gives a pixel beyond the pyramid both roles in the outermost level;
/// - lets an angle pass if it is below the limit, and takes the smallest height's angles, enlarged;
/// - encodes the camera at the smallest height and enlarges its features;
/// - takes ŵ_l of a term from the masks on its layer's grid;
/// - clamps the stored values of each layer after every step, the sum of the layers never;
/// - has its own sizes of the style (style_sizes), visits the views in recorded order, and the last hundredth of them not at all.
enum class Protocol
{
    paper,
    released_scannet,
    released_matterport3d
};
constexpr bool is_released(Protocol protocol)
{
    return protocol != Protocol::paper;
}

/// Factor of image gradients (StyleMesh, section 3.5).
enum class GradientScaling
{
    none,   ///< 1 in the level.
    level,  ///< The level's share in the pixel.
    angle   ///< The level's share times cos α.
};

/// Assigns the pixels of a view to heights, and selects those that losses see.
struct LevelRules
{
    Protocol protocol = Protocol::paper;
    bool by_depth = false;        ///< Depth levels; else every height shows every pixel.
    double theta_d_m = 0.25;      ///< θ_d, smaller for scans of short range.
    double angle_limit_deg = 90;  ///< Largest angle between normal and view for the fine style loss (StyleMesh, section 3.3).
    GradientScaling scaling = GradientScaling::angle;
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
/// If R lies at the share t of the way to the second, the first has the weight 1 - t: the formula that the paper prints would
/// give 0 at an exact hit. `heights_px`: ascending, not empty. `theta_d_m`: θ_d, smaller for scans of short range.
LevelChoice level_choice(double depth_m, std::span<const int> heights_px, double theta_d_m);

/// The pixels of one rendered height that take part.
struct LevelPixels
{
    Raster8 all;                 ///< H x W: 1 = belongs to the level.
    Raster8 fine;                ///< H x W: 1 = also passes the angle filter.
    RasterF weight;              ///< H x W: share of the level in the pixel, [0,1].
    RasterF cosine;              ///< H x W: cos α that the scaling uses; empty: the uv map's own.
    std::int64_t count() const;  ///< Pixels in `all`.
};

/// The levels of a view. By depth, assignment, weights and the 3x3 erosion (outside the picture is background) are computed on
/// the smallest height and resampled by nearest neighbor; a mask is eroded after the union of its two roles, weights per role. In
/// the paper's protocol, pixels that are invalid at their own height are left out. Not by depth, every such pixel belongs to
/// every height with weight 1; in a released one, the pixels with depth, while every pixel's gradient counts. \param maps   one
/// per height, ascending \param depth  of the smallest height's pixels in meters, 0 = belongs to no level; the paper's uses it by
/// depth only
std::vector<LevelPixels> levels_of(std::span<const UvMap> maps, const Raster<double>& depth, const LevelRules& rules);

/// ŵ_l of StyleMesh, section 3.4: the covered share of each level, divided by the sum of the shares; all zero without any pixel.
std::vector<double> level_shares(std::span<const LevelPixels> levels);

/// 0 where the level has no share.
RasterF gradient_factor(const UvMap& map, const LevelPixels& pixels, GradientScaling scaling);

/// Pixel among `from` that the released code looks up for pixel `i` of `to` (PyTorch's nearest neighbor, in single precision).
int corner_pixel(int i, int to, int from);

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
    PixelBox core;     ///< Pixels whose features are used.
    PixelBox encoded;  ///< The core and the pixels that its features see.
};

/// How frames are cut into crops.
struct CropRules
{
    int align;                 ///< Boxes begin at multiples of it, and end there or at the frame's border.
    int margin_px;             ///< Pixels beyond its own cell that a feature sees.
    std::int64_t crop_px = 0;  ///< As many pixels as cost what each crop costs beside its own.
};

/// Crops whose cores are disjoint and together hold every pixel of `mask`; one of the whole frame where crops would save less
/// than a tenth of its pixels, none for an empty mask. A network whose strides divide `align` gives in a crop's core what it
/// gives in the whole frame.
std::vector<Crop> covering_crops(const Raster8& mask, const CropRules& rules);

}  // namespace fresco::optimize
