#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/raycast/scene.h>

#include <cstdint>

/// What of a mesh a camera sees at its pixel centers.
struct ViewSurface
{
    fresco::Camera camera;
    fresco::RasterF depth;                    ///< H x W, meters along the optical axis; 0 = no front of a face.
    fresco::Raster8 inner;                    ///< H x W, 1 where the pixel and its eight neighbors within the picture have depth.
    fresco::Raster<std::uint32_t> triangles;  ///< H x W; Hit::none where depth is 0.

    /// World point at a pixel center. \pre depth.at(x, y) > 0
    fresco::Vec3d point(int x, int y) const
    {
        return camera.world_from_camera.translation + camera.ray(x + 0.5, y + 0.5) * double{depth.at(x, y)};
    }
};

/// Casts the camera's rays, as uvmaps.raycast judges them. Equal for any progress.threads(). Throws Canceled.
ViewSurface view_surface(const fresco::raycast::Scene& scene, const fresco::Camera& camera, const fresco::Progress& progress);

/// Fills `inner` from `depth`.
void find_inner_pixels(ViewSurface& view);
