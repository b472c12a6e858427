#pragma once

#include "depth_view.h"
#include "volume.h"

#include <fresco/progress.h>

#include <span>

namespace fuse
{

/// Averages what the views measured into the voxels. A voxel that a camera sees takes its distance from the plane of the pixel
/// that it falls on, at most `truncation_m`; behind the plane it counts less the deeper it lies, from one voxel on, and not at
/// all from `truncation_m` on. `truncation_m` is at least a voxel. Blocks are shared out among threads, each takes the views in
/// their order: the result does not depend on the number of threads. Curless and Levoy, "A volumetric method for building complex
/// models from range images" (1996).
void integrate(std::span<const DepthView> views, double truncation_m, const fresco::Progress& progress, Volume& volume);

}  // namespace fuse
