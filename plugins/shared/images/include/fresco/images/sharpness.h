#pragma once

#include <fresco/image.h>

namespace fresco
{

/// Variance of the Laplacian of the gray picture: large for sharp pictures, small for blurred ones; 0 for an even one. The
/// picture is first sampled at width x height by nearest neighbor (the value depends on the size), then made gray (0.299 R +
/// 0.587 G + 0.114 B, rounded); the Laplacian is the 4-neighbor one with borders mirrored about the edge pixel. After
/// Pech-Pacheco et al., "Diatom autofocusing in brightfield microscopy" (ICPR 2000). `rgb` has 3 channels, 0..255, and is not
/// empty; width, height >= 2. Thread-safe. The same value on every machine.
double sharpness(const Raster8& rgb, int width, int height);

/// At 320 x 240, where StyleMesh measures it: its threshold holds there.
double usual_sharpness(const Raster8& rgb);

}  // namespace fresco
