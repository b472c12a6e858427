#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/raycast/scene.h>

#include <cstdint>
#include <span>
#include <vector>

namespace fresco::virtual_views
{

/// The surface at one cell of the grid over the texture.
struct SurfacePoint
{
    Vec3f position;
    Vec3f normal;  ///< Of the face, unit length; zero where the face has no area: nobody sees that.
    std::uint32_t face = 0;
    std::uint32_t chart = 0;
    std::uint32_t cell = 0;  ///< Row by row.
};

/// The points of all cells of a cells_px x cells_px grid whose center lies in a chart, row by row. The mesh needs texcoords.
std::vector<SurfacePoint> surface_points(const Mesh& mesh, int cells_px, const Progress& progress);

/// What the eye sees of the points `asked`, in their order: those that face it, are at least nearest_surface_m away and have
/// nothing but the surface within a millimeter before them. Thread-safe.
std::vector<std::uint32_t> visible_points(const raycast::Scene& scene, std::span<const SurfacePoint> points, Vec3d eye,
                                          std::span<const std::uint32_t> asked);

/// Whether a camera's picture, without what its mask ignores (see load_mask), holds the point, hidden or not.
bool in_picture(const Camera& camera, const Raster8& mask, Vec3f position);

}  // namespace fresco::virtual_views
