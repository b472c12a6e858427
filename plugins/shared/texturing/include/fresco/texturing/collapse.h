#pragma once

#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/texture.h>

namespace fresco::texturing
{

/// Throws Error unless the texture is what its contract says: 1 or more square layers of 3 channels, layer i of size S / 2^i,
/// `seen` of S x S, known values.
void check_texture(const Texture& texture);

/// The texture's picture at full size, S x S x 3: displayed RGB in [0,1], the sum over the layers of a bilinear lookup at each
/// texel center. Rows are shared among progress.threads() threads. Throws Error if a texel is not finite, Canceled.
RasterF collapse(const Texture& texture, const Progress& progress);

/// Displayed RGB in steps of 1/255; what lies outside [0,1] is clamped.
Raster8 to_bytes(const RasterF& rgb, const Progress& progress);

}  // namespace fresco::texturing
