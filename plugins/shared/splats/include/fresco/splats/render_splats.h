#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/parallel.h>
#include <fresco/splats/splats.h>

/// \file Pictures of Gaussian splats. scan.splats takes color and depth from them, from which mesh.fuse makes a surface.

namespace fresco::splats
{

/// A picture as a camera sees the splats; all of the camera's size.
struct SplatPicture
{
    RasterF color;          ///< 3 channels, sRGB, over black; may leave [0,1] as the splats' colors do.
    RasterF transmittance;  ///< 0 to 1: the share of what lies behind that shows through.
    RasterF depth;          ///< Meters along the optical axis where the transmittance falls below one half; 0: nowhere.
};

/// Draws the splats from front to back: Kerbl et al., "3D Gaussian splatting for real-time radiance field rendering" (2023), with
/// base colors only. A Gaussian's depth is a plane over its footprint, through the points where rays meet most of it, so that
/// flat ones lie as they lie in space. Splats are in the camera's world; those whose centers are nearer than `nearest_m` along
/// the optical axis are left out. The same for any number of threads. Throws Canceled.
SplatPicture render_splats(const Splats& splats, const Camera& camera, double nearest_m, const Progress& progress);

}  // namespace fresco::splats
