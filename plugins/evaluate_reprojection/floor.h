#pragma once

#include "covisible.h"

#include <fresco/progress.h>
#include <fresco/raycast/mip_maps.h>
#include <fresco/raycast/view_renderer.h>
#include <fresco/texture.h>

#include <cstdint>
#include <vector>

/// A mesh's colors, looked up so coarsely that none of two cameras undersamples them.
class SurfacePaint
{
  public:
    virtual ~SurfacePaint() = default;

    /// RGB in 0..255 at a point of a triangle's plane, the same for (a, b) as for (b, a). Thread-safe.
    virtual fresco::Vec3d color(std::uint32_t triangle, fresco::Vec3d point, const fresco::Camera& a,
                                const fresco::Camera& b) const = 0;

  protected:
    SurfacePaint() = default;
    SurfacePaint(const SurfacePaint&) = default;
    SurfacePaint& operator=(const SurfacePaint&) = default;
};

/// The picture of a textured mesh.
class TexturePaint final : public SurfacePaint
{
  public:
    /// The mesh must have texcoords and outlive this. `lights` as the judged pictures have them. Throws Error unless the picture
    /// is RGB.
    explicit TexturePaint(const fresco::TexturedMesh& textured, const fresco::raycast::Lights& lights = {});
    fresco::Vec3d color(std::uint32_t triangle, fresco::Vec3d point, const fresco::Camera& a,
                        const fresco::Camera& b) const override;

  private:
    const fresco::Mesh& mesh_;
    fresco::raycast::MipMaps picture_;
    fresco::raycast::Lighting lighting_;
};

/// A picture thrown from its camera onto the mesh: for pictures that no texture was made of.
class ProjectedPaint final : public SurfacePaint
{
  public:
    /// `picture` has the camera's size; the mesh must outlive this.
    ProjectedPaint(const fresco::Mesh& mesh, const fresco::Camera& camera, const fresco::Raster8& picture);
    fresco::Vec3d color(std::uint32_t triangle, fresco::Vec3d point, const fresco::Camera& a,
                        const fresco::Camera& b) const override;

  private:
    double pixels_per_pixel(std::uint32_t triangle, fresco::Vec3d point, const fresco::Camera& other) const;

    const fresco::Mesh& mesh_;
    fresco::Camera camera_;
    fresco::raycast::MipMaps picture_;
};

/// What two cameras would see of a low-passed surface, RGB; drawn where the matches need it, black elsewhere. The measure between
/// them is the resampling floor. Equal for any progress.threads(). Throws Canceled.
struct FloorPictures
{
    fresco::Raster8 source;
    fresco::Raster8 target;
};
FloorPictures floor_pictures(const ViewSurface& source, const ViewSurface& target, const std::vector<Match>& matches,
                             const SurfacePaint& paint, const fresco::Progress& progress);
