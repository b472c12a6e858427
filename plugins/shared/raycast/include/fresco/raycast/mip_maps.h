#pragma once

#include <fresco/image.h>
#include <fresco/math.h>

#include <cstdint>
#include <vector>

namespace fresco::raycast
{

/// An RGB picture at every size down to 1 x 1, each the area average of the one before, in 16 bits per channel.
class MipMaps
{
  public:
    /// `smaller_levels` false: the full size only. Throws Error unless the picture has 3 channels.
    MipMaps(const Raster8& picture, bool smaller_levels);

    int width() const { return levels_.front().width; }
    int height() const { return levels_.front().height; }

    /// The color (0..255 per channel) at uv, origin lower left: bilinear with texel centers at +0.5, clamped at the borders, and
    /// linear between the two levels around `lod` (0 = full size, 1 = half, …).
    Vec3d sample(Vec2d uv, double lod) const;

  private:
    Vec3d sample_level(Vec2d uv, std::size_t level) const;

    std::vector<Raster<std::uint16_t>> levels_;
};

}  // namespace fresco::raycast
