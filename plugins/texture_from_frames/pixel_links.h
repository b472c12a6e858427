#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/uv_maps.h>

#include <cstdint>

namespace fresco::from_frames
{

/// Which neighboring pixels of a uv map show neighboring points: of one surface, and of one chart of the atlas.
class PixelLinks
{
  public:
    enum Link : std::uint8_t
    {
        surface_right = 1,  ///< No depth step between this pixel and the next one in its row …
        surface_down = 2,   ///< … in its column.
        texels_right = 4,   ///< Also close in the texture, so that the texels between may be interpolated.
        texels_down = 8
    };

    /// `camera`: the color camera at any size.
    ///
    /// A depth step is where 1 / depth, which runs linearly over a plane in any direction, jumps by more than 2 % + 1 cm from
    /// what the pixels on either side continue; so oblique walls and their corners have none. Two pixels are far apart in the
    /// texture where their texcoords differ by more than five times what their distance in the world explains: charts have one
    /// scale, or nearly so, and the view's lower quartile of texture per meter is taken for it.
    PixelLinks(const UvMap& map, const Camera& camera);

    bool has(int x, int y, Link link) const { return (links_.at(x, y) & link) != 0; }

    double texture_per_m() const { return texture_per_m_; }

    /// H x W: 1 = valid and beside a depth step or a pixel that sees nothing.
    Raster8 at_steps() const;

  private:
    void link_surfaces(const UvMap& map);
    void link_texels(const UvMap& map, const Camera& camera);

    Raster8 links_;
    Raster8 valid_;
    double texture_per_m_ = 1;
};

}  // namespace fresco::from_frames
