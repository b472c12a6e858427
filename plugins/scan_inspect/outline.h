#pragma once

#include "agreement.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/raycast/scene.h>

#include <vector>

namespace fresco::inspect
{

/// Depth of the mesh at the pixel centers of a camera, along the optical axis; 0 where nothing is met. Whichever side of a face
/// is met counts. The same for any number of threads. Throws Canceled.
RasterF mesh_depth(const raycast::Scene& scene, const Camera& camera, const Progress& progress);

/// Nearest neighbor: depths on both sides of a step must not mix.
RasterF nearest_sampled(const RasterF& depth, int width, int height);

/// Pixels of the near side of depth steps: the next depth to the right, left, above or below is farther by more than 8 % and 4 %
/// for each pixel without depth between, of which there may be two; with `ends`, also where three pixels have none: a mesh may be
/// cut off there. H x W, 1 = outline.
Raster8 outline(const RasterF& depth, bool ends);

/// At most 400 outline pixels of a depth picture.
std::vector<DepthSample> silhouette(const RasterF& depth);

/// How strongly a picture changes at each pixel: the length of the gradient of its log brightness, the largest of 3 x 3 pixels
/// (a recorded pose is off by a pixel or two), divided by its mean around and over the picture, at most 4. H x W.
RasterF edge_strength(const Raster8& rgb);

}  // namespace fresco::inspect
