#pragma once

#include <fresco/image.h>
#include <fresco/math.h>

#include <cstdint>
#include <vector>

namespace fresco::raycast
{

/// An RGB picture at every size down to 1 x 1, each the area average of the one before; the smaller ones in 16 bits per channel.
class MipMaps
{
  public:
    /// `smaller_levels` false: the full size only. Throws Error unless the picture has 3 channels.
    MipMaps(Raster8 picture, bool smaller_levels);

    int width() const { return picture_.width; }
    int height() const { return picture_.height; }

    /// The color (0..255 per channel) at uv, origin lower left: bilinear with texel centers at +0.5, clamped at the borders, and
    /// linear between the two levels around `lod` (0 = full size, 1 = half, …).
    Vec3d sample(Vec2d uv, double lod) const;

  private:
    Vec3d sample_level(Vec2d uv, std::size_t level) const;

    Raster8 picture_;
    std::vector<Raster16> smaller_;
};

}  // namespace fresco::raycast
