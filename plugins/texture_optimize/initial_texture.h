#pragma once

#include "view_source.h"

#include <fresco/progress.h>

#include <string>
#include <vector>

namespace fresco::optimize
{

/// What the texture begins as: displayed RGB in [0,1].
struct InitialTexture
{
    RasterF picture;  ///< S x S x 3; empty where the texture begins at zero.
    Raster8 seen;     ///< S x S: 1 = in the bilinear footprint of some view's pixel.
};

/// `init`: "zeros"; "color", the mean of `style`; "noise" with its mean and deviation; or "frames": the camera colours gathered
/// through the uv maps of the largest height, recoloured to the style by the linear Monge-Kantorovich map, and filled in where no
/// view looks. Reads every view once, a few at a time. `style`: RGB in [0,1]. The same bytes for any number of threads.
InitialTexture initial_texture(const ViewSource& source, const std::vector<std::size_t>& views, const RasterF& style,
                               const std::string& init, int size_px, std::uint64_t seed, Progress& progress);

}  // namespace fresco::optimize
