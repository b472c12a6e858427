#pragma once

#include <fresco/image.h>
#include <fresco/images/lab.h>

#include <cstdint>
#include <span>
#include <vector>

namespace fresco
{

/// Moves colors to those of a picture: by the linear map of monge_kantorovich, and from there, where the picture has too little
/// of a color to paint a surface from, toward the colors nearby that it has enough of. A color that it has enough of stays
/// exactly.
class Recoloring
{
  public:
    /// `from`: the colors that are recolored, RGB in [0,1]. `picture`: H x W x 3. `opaque`: H x W, 0 for pixels that do not
    /// count; empty: all do.
    Recoloring(const ColorMoments& from, const Raster8& picture, std::span<const std::uint8_t> opaque);

    /// RGB in [0,1].
    Vec3f operator()(Vec3f rgb) const;

  private:
    ColorMap map_;
    std::vector<Vec3f> moves_;  ///< In L*a*b*, at the nodes of a grid over RGB.
};

}  // namespace fresco
