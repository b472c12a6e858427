#pragma once

#include "surface_points.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/progress.h>

#include <cstddef>
#include <vector>

namespace fresco::align
{

/// One view as the alignment sees it.
struct AlignedView
{
    Intrinsics intrinsics;            ///< Of the color camera.
    std::vector<Sighting> sightings;  ///< Ascending points.
    std::vector<RasterF> levels;      ///< Brightness (brightness_levels), coarsest first.
};

/// Logarithms of the gray picture (0.299 R + 0.587 G + 0.114 B, plus 0.03) at heights of 60, 120 and 240 px, as far as the
/// picture is that high; one level at least.
std::vector<RasterF> brightness_levels(const Raster8& rgb);

struct AlignmentRules
{
    int rounds_count;       ///< Per level, at most.
    double likely_turn;     ///< Standard deviation of a camera's error that is expected: radians …
    double likely_shift_m;  ///< … and meters.
};

struct Alignment
{
    std::vector<RigidTransform> corrected_from_recorded;  ///< Per view: between its color cameras.
    std::vector<double> moved_px;  ///< Per view: by how much its sightings moved in its full-size picture, root mean square.
    /// Mean difference of a view's log brightness to the mean of all that see the point, on the finest level, with the
    /// exposures taken out; as recorded …
    double error_before = 0;
    double error_after = 0;  ///< … and corrected.
};

/// Turns and shifts each color camera so that all views agree on the brightness of the points that they see (Zhou and Koltun,
/// "Color map optimization for 3D reconstruction with consumer depth cameras", SIGGRAPH 2014, section 4), from coarse to fine
/// pictures. Rounds alternate between the points' brightness, a robust mean over the views, and one Gauss-Newton step with
/// momentum for each view, which also finds its exposure; a prior holds cameras where pictures say little.
/// About 36 bytes a sighting. The same for any number of threads. Throws Canceled.
Alignment align(const std::vector<AlignedView>& views, std::size_t points, const AlignmentRules& rules, Progress& progress);

}  // namespace fresco::align
