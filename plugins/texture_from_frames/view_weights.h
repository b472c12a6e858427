#pragma once

#include "pixel_links.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/uv_maps.h>

#include <cstddef>

namespace fresco::from_frames
{

struct WeightRules
{
    double edge_margin_px;      ///< Pixels of the camera's picture beside a depth step that are not trusted.
    double sensor_tolerance_m;  ///< With 5 % of the depth: how far the measured depth may be from the mesh's.
};

/// What each pixel of a view is worth.
struct ViewWeights
{
    /// H x W in [0,1]: 0 at the picture's border, beside depth steps, and where something else than the mesh was in front; rises
    /// to 1 away from them, so that views begin and end softly.
    RasterF trust;
    /// H x W, above 0 to 1: what a pixel counts among views. cos α, times the share of a quarter of a picture pixel that there is
    /// per texel (f² cos α / z² over the texture's density; 1 where there is more), times trust; at least a thousandth of it
    /// where only trust is missing, for what no other view shows. 0: rejected, or invalid.
    RasterF weight;
    std::size_t edge_pixels = 0;      ///< Without trust, for being beside a depth step.
    std::size_t rejected_pixels = 0;  ///< Measured elsewhere than the mesh is.
};

/// \param camera    the color camera at full size
/// \param measured  what the depth camera measured for each pixel of the map, meters, 0 = nothing; empty: no depth picture
/// \param size_px   texels a side of the texture
ViewWeights view_weights(const UvMap& map, const PixelLinks& links, const Camera& camera, const RasterF& measured, int size_px,
                         const WeightRules& rules);

/// Distance in pixels from each pixel to the nearest marked one, along steps to the eight neighbors (1 or √2; at most 8 % too
/// long); a large number where none is marked. After Borgefors, "Distance transformations in digital images" (1986).
RasterF distance_to(const Raster8& marked);

}  // namespace fresco::from_frames
