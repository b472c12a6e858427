#pragma once

#include <fresco/image.h>

/// \file Filters of pictures. Beyond its border a picture goes on mirrored, the outermost pixel not repeated.

/// Gaussian blur of each channel; `sigma_px` > 0. The kernel reaches 4 sigma to either side and sums to 1.
fresco::RasterF blurred(const fresco::RasterF& picture, double sigma_px);

/// Sobel's derivatives of a picture of one channel, 8 times the slope per pixel.
struct Gradient
{
    fresco::RasterF x;
    fresco::RasterF y;
};
Gradient sobel(const fresco::RasterF& plane);

/// 1 where every pixel of the picture within `radius_px` along both axes (a square) is set, else 0. Beyond the border all are.
fresco::Raster8 eroded(const fresco::Raster8& mask, int radius_px);

/// One channel of a picture.
fresco::RasterF channel(const fresco::RasterF& picture, int index);
