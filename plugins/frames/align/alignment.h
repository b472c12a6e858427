#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/mesh.h>
#include <fresco/parallel.h>

#include <cstddef>
#include <cstdint>
#include <vector>

/// \file Corrects the poses of color cameras by the colors of the surface. The stage chooses points, finds the views that see
/// them, and aligns the views.

namespace fresco::align
{

/// A point of the surface at which views are compared.
struct SurfacePoint
{
    Vec3f position;  ///< World, meters.
    Vec3f normal;
};

/// Evenly spread vertices of the mesh: the first in each cell of a cubic grid. Cells are 5 mm, 7 mm, 1 cm, … (steps of √2): the
/// smallest size with at most `most` points.
std::vector<SurfacePoint> surface_points(const Mesh& mesh, std::size_t most);

/// A point as seen by a view.
struct Sighting
{
    std::uint32_t point = 0;
    float weight = 0;  ///< Cosine of the angle between normal and view.
    Vec3f in_camera;   ///< The point in the color camera as recorded, meters.
};

/// The points that a camera sees, except beside depth steps: within two pixels, all depths are those of the point to 3 % + 2 cm.
/// `depth`: the mesh's, of the camera's size, meters, 0 = none. Ascending.
std::vector<Sighting> sightings(const std::vector<SurfacePoint>& points, const Camera& camera, const RasterF& depth);

/// The input of one view.
struct AlignedView
{
    Intrinsics intrinsics;            ///< Intrinsics of the color camera.
    std::vector<Sighting> sightings;  ///< Ascending points.
    std::vector<RasterF> levels;      ///< Brightness (brightness_levels), coarsest first.
};

/// Logarithms of the gray picture (0.299 R + 0.587 G + 0.114 B, plus 0.03) at heights of 60, 120 and 240 px, up to the
/// height of the picture; at least one level.
std::vector<RasterF> brightness_levels(const Raster8& rgb);

struct AlignmentRules
{
    int rounds_count;       ///< Maximum per level.
    double likely_turn;     ///< Expected standard deviation of a camera's rotation error, radians.
    double likely_shift_m;  ///< Expected standard deviation of its position error, meters.
};

struct Alignment
{
    std::vector<RigidTransform> corrected_from_recorded;  ///< Per view: motion of its color camera.
    std::vector<double> moved_px;  ///< Per view: root mean square motion of its sightings in the full-size picture.
    /// Mean difference between a view's log brightness and the mean of all views that see the point, on the finest level, without
    /// the effect of exposures; as recorded.
    double error_before = 0;
    double error_after = 0;  ///< The error after the correction.
};

/// Rotates and shifts each color camera so that all views agree on the brightness of the points that they see (Zhou and Koltun,
/// "Color map optimization for 3D reconstruction with consumer depth cameras", SIGGRAPH 2014, section 4), from coarse to fine
/// pictures. Rounds alternate between the points' brightness, a robust mean over the views, and one Gauss-Newton step with
/// momentum for each view, which also finds its exposure; a prior keeps cameras near their recorded poses if pictures have little
/// detail. Small
/// pictures compare fewer points. Takes about 60 bytes per sighting. The same for any number of threads. Throws Canceled.
Alignment align(const std::vector<AlignedView>& views, std::size_t points, const AlignmentRules& rules, Progress& progress);

}  // namespace fresco::align
