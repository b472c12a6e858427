#pragma once

#include <fresco/image.h>
#include <fresco/progress.h>

#include <cstdint>
#include <vector>

namespace fresco::texturing
{

/// Gives every texel that is no source the color of its nearest source (exact Euclidean distance between centers; of equally
/// near ones the same is taken for any thread count), so that bilinear lookups and mip-maps find no foreign color at a chart's
/// border. `is_source`: W x H. Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions" (2012). Throws Error if
/// there is no source, Canceled.
void fill_from_nearest(Raster8& image, const std::vector<std::uint8_t>& is_source, const Progress& progress);

}  // namespace fresco::texturing
