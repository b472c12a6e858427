#pragma once

#include <fresco/image.h>

#include <algorithm>
#include <cmath>

/// \file Filters of pictures. Beyond its border a picture goes on mirrored, the outermost pixel not repeated.

namespace fresco
{

/// By nearest neighbor: pixel i takes the source's floor(i · from / to), rounded as OpenCV rounds it. `raster` is not empty.
template <class T>
Raster<T> nearest_sampled(const Raster<T>& raster, int width, int height)
{
    const auto pixel = [](int i, int to, int from)
    { return std::min(static_cast<int>(std::floor(i * (1 / (static_cast<double>(to) / from)))), from - 1); };
    Raster<T> result(width, height, raster.channels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            std::copy_n(&raster.at(pixel(x, width, raster.width), pixel(y, height, raster.height)), raster.channels,
                        &result.at(x, y));
    return result;
}

/// The size in which the released preparation of StyleMesh exports pictures and depth of ScanNet.
template <class T>
Raster<T> exported_for_stylemesh(const Raster<T>& raster)
{
    return nearest_sampled(raster, 320, 240);
}

/// Gaussian blur of each channel; `sigma_px` > 0. The kernel reaches 4 sigma to either side and sums to 1.
RasterF blurred(const RasterF& picture, double sigma_px);

/// The variance of a picture around each pixel, summed over its channels, in a Gaussian window: one channel.
RasterF local_variance(const RasterF& picture, double sigma_px);

/// Sobel's derivatives of a picture of one channel, 8 times the slope per pixel.
struct Gradient
{
    RasterF x;
    RasterF y;
};
Gradient sobel(const RasterF& plane);

/// An RGBA picture of straight alpha on a gray of this level: RGB.
Raster8 on_gray(const Raster8& rgba, int level);

/// One channel of a picture.
RasterF channel(const RasterF& picture, int index);

/// Fills what is not covered from coarser and coarser means of what is (Gortler et al., "The Lumigraph", SIGGRAPH 1996,
/// section 3.4): smooth, near texels first. `picture`: W x H x C; `covered`: W x H. Covered values stay; nothing covered leaves
/// the picture as it is.
void push_pull(RasterF& picture, const Raster8& covered);

}  // namespace fresco
