#pragma once

#include <fresco/image.h>

#include <functional>
#include <string>

namespace fresco::optimize
{

/// The two sizes of the style picture, RGB in [0,1] (METHOD section 4).
struct StyleSizes
{
    RasterF fine;
    RasterF coarse;
};

/// Alpha is composited on white and grey spread over three channels. A longer side over 2048 px is first reduced to 2048; `fine`
/// has a shorter side of exactly 256 px, never enlarged (then `message` says so); `coarse` is four times as large, at most the
/// picture. Throws Error for an empty picture or another number of channels than 1, 3 or 4.
StyleSizes style_sizes(const Raster8& picture, const std::function<void(const std::string&)>& message);

}  // namespace fresco::optimize
