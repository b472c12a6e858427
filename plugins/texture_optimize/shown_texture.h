#pragma once

#include <fresco/texture.h>
#include <fresco/uv_maps.h>

#include <vector>

namespace fresco::optimize
{

/// The sum of the layers, clamped to [0,1]. \pre values: display
RasterF displayed(const Texture& texture);

/// A texture as views without a picture show it.
class ShownTexture
{
  public:
    /// As displayed. Keeps a copy at full, half, quarter … size.
    explicit ShownTexture(const Texture& texture);

    /// RGB of the map's size; black where it is not valid. Each pixel looks up the size of the texture at which its neighbors
    /// are about a texel away, bilinearly: fine detail does not flicker where a view is coarser than the texture.
    Raster8 shown(const UvMap& map) const;

  private:
    std::vector<RasterF> sizes_;
};

}  // namespace fresco::optimize
