#pragma once

#include <fresco/image.h>
#include <fresco/math.h>

#include <cstdint>
#include <vector>

/// An RGB picture at every size down to 1 x 1, each the area average of the one before, in 16 bits per channel.
class MipMaps
{
  public:
    /// `smaller_levels` false: the full size only. Throws Error unless the picture has 3 channels.
    MipMaps(const fresco::Raster8& picture, bool smaller_levels);

    int size_px() const { return levels_.front().width; }

    /// The colour (0..255 per channel) at uv, origin lower left: bilinear with texel centres at +0.5, clamped at the borders, and
    /// linear between the two levels around `lod` (0 = full size, 1 = half, …).
    fresco::Vec3d sample(fresco::Vec2d uv, double lod) const;

  private:
    fresco::Vec3d sample_level(fresco::Vec2d uv, std::size_t level) const;

    std::vector<fresco::Raster<std::uint16_t>> levels_;
};
