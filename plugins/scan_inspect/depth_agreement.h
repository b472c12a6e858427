#pragma once

#include "convention.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/progress.h>
#include <fresco/raycast/scene.h>

#include <cstddef>
#include <vector>

namespace fresco::inspect
{

/// A depth that was measured at a place of the depth picture.
struct DepthSample
{
    float x = 0;  ///< Pixel coordinates, …
    float y = 0;
    float depth = 0;  ///< … meters as recorded, along the optical axis.
};

/// A frame's depth camera and what it measured on a grid over its picture.
struct SampledDepth
{
    Camera camera;
    std::vector<DepthSample> samples;
};

/// The measured pixels of a depth picture (0 = none) at the centers of a grid of about `columns` columns, row by row.
std::vector<DepthSample> sample_depth(const RasterF& depth, int columns);

/// What the mesh has where depths were measured: mesh depth over measured depth, 0 where the mesh has nothing.
struct DepthRatios
{
    std::vector<double> ratios;  ///< Ascending.
    std::size_t seen = 0;        ///< Samples where the mesh has something.
    std::size_t fronts = 0;      ///< Of these, fronts of faces.

    /// The share of all samples whose mesh depth is within `tolerance` (0.03 = 3 %) of `scale` times the measured one.
    double share(double scale, double tolerance) const;
    /// Mean over all samples of the relative difference, each at most 10 %.
    double loss(double scale) const;
    /// Median of the relative difference over samples where the mesh has something; 1 if there are none.
    double median_error(double scale) const;
    /// The scale with the largest share within 3 %; 1 where the mesh is never seen.
    double best_scale() const;
};

/// Casts the samples' rays from cameras as `convention` has them, their focal lengths multiplied by `focal_scale`. Every
/// `stride`-th sample alone. Whichever side of a face is met counts. The same for any number of threads. Throws Canceled.
DepthRatios depth_ratios(const raycast::Scene& scene, const std::vector<SampledDepth>& frames, const Convention& convention,
                         double focal_scale, std::size_t stride, const Progress& progress);

}  // namespace fresco::inspect
