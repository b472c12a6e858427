#pragma once

#include <fresco/camera.h>
#include <fresco/frames.h>
#include <fresco/progress.h>
#include <fresco/raycast/mip_maps.h>
#include <fresco/raycast/scene.h>
#include <fresco/texture.h>

#include <cstdint>

namespace fresco::raycast
{

struct RenderOptions
{
    int samples_per_side = 2;  ///< Rays per pixel: its square.
    bool mip_maps = true;      ///< Look up the picture at the size that one ray's spacing calls for.
};

/// Throws Error unless a stage with these on its ports `mesh` and `frames` can show the mesh as the frames' colour cameras do: a
/// valid mesh with texcoords, and frames whose colour cameras are usable.
void check_showable(const TexturedMesh& mesh, const Frames& frames);

/// Draws a textured mesh as cameras see it.
class ViewRenderer
{
  public:
    /// The mesh must have passed check_mesh, have texcoords and outlive the renderer. Throws Error if the picture is not RGB.
    ViewRenderer(const TexturedMesh& mesh, const RenderOptions& options);

    /// RGBA, straight alpha: the share of the pixel's rays that meet the front of a face (as uvmaps.raycast judges it), and the
    /// mean colour of these. Equal for any progress.threads(). Throws Cancelled.
    Raster8 render(const Camera& camera, const Progress& progress) const;

  private:
    void render_rows(const Camera& camera, const Camera& dense, int first_row, int end_row, Raster8& image) const;
    double level_of_detail(const Camera& dense, int x, int y, const Hit& hit, Vec2d uv) const;

    RenderOptions options_;
    Scene scene_;
    MipMaps texture_;
};

}  // namespace fresco::raycast
