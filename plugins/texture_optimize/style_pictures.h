#pragma once

#include <fresco/image.h>

#include <functional>
#include <string>

namespace fresco::optimize
{

/// How the sizes are found (StyleMesh, section 3.3).
enum class StyleRule
{
    printed,  ///< As style_sizes says.
    released  ///< As the authors' code does it.
};

/// The two sizes of the style picture, RGB in [0,1] (StyleMesh, section 3.3).
struct StyleSizes
{
    RasterF fine;
    RasterF coarse;
};

/// Alpha is composited on white and gray spread over three channels. A longer side over 2048 px is first reduced to 2048; `fine`
/// has a shorter side of exactly 256 px, never enlarged (then `message` says so); `coarse` is four times as large, at most the
/// picture. Released: where a side is over 2048 px, the shorter becomes 2048, which may enlarge; then `fine` has a shorter side
/// of 256 px, enlarged too, and `coarse` is the third of these: 256 px, the halvings that are no smaller, ascending (256 px again
/// where one is), the picture. Both without antialiasing. Throws Error for a side below 64 px or another number of channels than
/// 1, 3 or 4.
StyleSizes style_sizes(const Raster8& picture, StyleRule rule, const std::function<void(const std::string&)>& message);

}  // namespace fresco::optimize
