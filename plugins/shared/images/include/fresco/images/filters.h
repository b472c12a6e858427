#pragma once

#include <fresco/image.h>

/// \file Filters of pictures. Beyond its border a picture goes on mirrored, the outermost pixel not repeated.

namespace fresco
{

/// Gaussian blur of each channel; `sigma_px` > 0. The kernel reaches 4 sigma to either side and sums to 1.
RasterF blurred(const RasterF& picture, double sigma_px);

/// Sobel's derivatives of a picture of one channel, 8 times the slope per pixel.
struct Gradient
{
    RasterF x;
    RasterF y;
};
Gradient sobel(const RasterF& plane);

/// 1 where every pixel of the picture within `radius_px` along both axes (a square) is set, else 0. Beyond the border all are.
Raster8 eroded(const Raster8& mask, int radius_px);

/// One channel of a picture.
RasterF channel(const RasterF& picture, int index);

/// Fills what is not covered from coarser and coarser means of what is (Gortler et al., "The Lumigraph", SIGGRAPH 1996,
/// section 3.4): smooth, near texels first. `picture`: W x H x C; `covered`: W x H. Covered values stay; nothing covered leaves
/// the picture as it is.
void push_pull(RasterF& picture, const Raster8& covered);

}  // namespace fresco
