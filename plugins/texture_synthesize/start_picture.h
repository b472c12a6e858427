#pragma once

#include "painted_surface.h"

#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/texture.h>
#include <fresco/texturing/texel_faces.h>

#include <cstddef>

namespace fresco::synthesize
{

/// What the painting begins with: a texture's displayed colors, continued along the surface to what it does not know.
class StartPicture
{
  public:
    /// `texture`: of the surface's atlas, at any size. Throws Error for a texture that knows no texel of the surface, Canceled.
    StartPicture(const PaintedSurface& surface, const Texture& texture, const Progress& progress);

    std::size_t chart_texels() const { return chart_texels_; }
    std::size_t known_texels() const { return known_texels_; }

    /// Maps its colors to a picture's (see fresco/recolor.h), clamped to [0,1].
    void recolor(const Raster8& picture);

    /// RGB in [0,1] at a texcoord of a chart, averaged over about `footprint` in texcoords; no other chart's colors enter.
    Vec3f at(std::uint32_t chart, Vec2f uv, double footprint) const;

  private:
    Vec3f bilinear(std::uint32_t chart, double x, double y, float& weight) const;

    const PaintedSurface& surface_;
    texturing::TexelFaces faces_;
    RasterF rgb_;
    std::size_t chart_texels_ = 0;
    std::size_t known_texels_ = 0;
};

}  // namespace fresco::synthesize
