#pragma once

#include <fresco/image.h>

#include <vector>

namespace fresco::laplacian
{

/// Splits an S x S x C picture into `count` layers of size S / 2^i, finest first: each coarse layer holds what the ones below it
/// lack of the area-averaged picture, and the finest the residual, so that the sum of bilinear lookups at the finest texel
/// centers is the picture to rounding (Burt and Adelson, "The Laplacian pyramid as a compact image code", 1983). S must be
/// divisible by 2^(count-1). The result does not depend on `threads`.
std::vector<RasterF> laplacian_layers(const RasterF& picture, int count, int threads);

}  // namespace fresco::laplacian
