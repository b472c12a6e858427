#pragma once

#include "convention.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/raycast/scene.h>

#include <utility>
#include <vector>

namespace fresco::inspect
{

/// Depth of the mesh at the pixel centers of a camera, along the optical axis; 0 where nothing is met. Whichever side of a face
/// is met counts. The same for any number of threads. Throws Canceled.
RasterF mesh_depth(const raycast::Scene& scene, const Camera& camera, const Progress& progress);

/// Pixels of the near side of depth steps: a neighbor to the right, left, above or below is farther by more than 8 %, or has
/// nothing. Borders of the picture are none. H x W, 1 = outline.
Raster8 outline(const RasterF& depth);

/// How strongly a picture changes at each pixel: the length of the gradient of its log brightness, the largest of 3 x 3 pixels
/// (a recorded pose is off by a pixel or two), divided by its mean over the picture. H x W.
RasterF edge_strength(const Raster8& rgb);

/// A color camera, its picture's edges, and where the mesh has its outline.
struct OutlinedFrame
{
    Camera camera;               ///< At the size of `edges`.
    RasterF edges;               ///< edge_strength; empty = there is no picture.
    std::vector<Vec3d> outline;  ///< World points, meters.
};

/// Fills `outline` with at most 400 points of the mesh's outline that the camera, as `convention` has its pose, sees.
void find_outline(const raycast::Scene& scene, const Convention& convention, OutlinedFrame& frame, const Progress& progress);

/// A focal length is looked for up to this natural logarithm of its factor, and a little beyond by finer steps.
inline constexpr double color_focal_reach = 0.24;

/// How a color camera may be off.
struct CameraChange
{
    double focal_scale = 1;
    double shift_x = 0;  ///< Of the principal point, in shares of the picture's width, …
    double shift_y = 0;  ///< … and of its height.
};

Intrinsics changed(const Intrinsics& recorded, const CameraChange& change);

/// Mean of the pictures' edge strength at the outlines, less 1: 0 where outline and picture have nothing to do with each other.
/// Points that fall outside count as 0; a frame with fewer than 50 points counts less, and at least half of the frames count.
double edge_response(const std::vector<OutlinedFrame>& frames, const Convention& convention, const CameraChange& change);

/// The responses without and with a change, both of the points that are within the picture either way: borders of a picture may
/// have fewer edges than its middle.
std::pair<double, double> compare_responses(const std::vector<OutlinedFrame>& frames, const Convention& convention,
                                            const CameraChange& change);

/// The change with the strongest response: focal lengths up to 25 % off, shifts up to 4 % of the width. Throws Canceled.
CameraChange best_change(const std::vector<OutlinedFrame>& frames, const Convention& convention, const Progress& progress);

}  // namespace fresco::inspect
