#pragma once

#include <fresco/geometry/topology.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>
#include <fresco/texturing/texel_faces.h>

#include <cstddef>
#include <utility>
#include <vector>

/// \file The mesh as the synthesis sees it: with its charts, the neighbors of faces across seams, smoothed normals, an upright
/// frame for patches at any normal, and the colors of the start texture. Patches, line field and synthesis are built on it.

namespace fresco::synthesize
{

/// Directions of a picture that lies on a surface: `right` and `down` as its x and y, `out` toward the viewer. Orthonormal.
struct TangentFrame
{
    Vec3f right, down, out;
};

/// The upward direction, and a horizontal one that replaces it on level surfaces. Orthonormal.
struct Upright
{
    Vec3f up, ahead;
};

/// A mesh with an atlas, prepared for laying patches on it. Refers to the mesh, which must outlive it.
struct PaintedSurface
{
    const Mesh& mesh;
    texturing::Charts charts;
    std::vector<double> uv_per_m;   ///< Per chart: texcoords along a meter, from the areas; 0 for a chart without area.
    geometry::Neighbors neighbors;  ///< F x 3, also across the atlas's seams and between vertices at one position.
    std::vector<double> areas;      ///< F, square meters.
    std::vector<Vec3f>
        normals;  ///< F, unit, smoothed over about ten rings of faces but not across edges; zero for a face without area.

    /// The mesh must have passed check_mesh and have texcoords. Throws Canceled.
    PaintedSurface(const Mesh& of, const Progress& progress);
};

/// The directions of u and v on a face, in meters per texcoord; zero for a face without area in the atlas.
std::pair<Vec3f, Vec3f> texcoord_axes(const Mesh& mesh, std::size_t face);

/// Finds `ahead`: the horizontal direction that most of the surface faces, from the area-weighted normals; the same for any order
/// of the faces up to rounding.
Upright upright(const PaintedSurface& surface, Vec3f up);

/// The frame of an upright picture on a surface: its top is up on walls and slopes, and points ahead on surfaces within 45
/// degrees of level.
TangentFrame frame_at(Vec3f normal, const Upright& upright);

/// The start of the painting: a texture's displayed colors, continued along the surface into its unseen texels.
class StartPicture
{
  public:
    /// `texture`: of the surface's atlas, at any size. Throws Error if no texel of the surface was seen; Canceled.
    StartPicture(const PaintedSurface& surface, const Texture& texture, const Progress& progress);

    const texturing::TexelFaces& faces() const { return faces_; }
    std::size_t chart_texels() const { return chart_texels_; }
    std::size_t known_texels() const { return known_texels_; }

    /// Maps its colors to a picture's (see fresco/images/recoloring.h). `opaque`: 0 for pixels that do not count; empty:
    /// all do.
    void recolor(const Raster8& picture, const Raster8& opaque = {});

    /// RGB in [0,1] at a texcoord of a chart, averaged over about `footprint` in texcoords; without colors of other charts.
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
