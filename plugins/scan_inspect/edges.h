#pragma once

#include "agreement.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/progress.h>

#include <vector>

namespace fresco::inspect
{

/// How a color camera may differ from what was recorded.
struct CameraChange
{
    double focal_scale = 1;
    double size_scale = 1;     ///< Multiplies all intrinsics.
    double shift_x = 0;        ///< Of the principal point, in shares of the picture's width, …
    double shift_y = 0;        ///< … and of its height.
    bool upside_down = false;  ///< The pictures are turned by 180 degrees.

    friend bool operator==(const CameraChange&, const CameraChange&) = default;
};

Intrinsics changed(const Intrinsics& recorded, const CameraChange& change);

/// A color picture's edges, and what should lie on them.
struct EdgeView
{
    Intrinsics camera;               ///< At the size of `edges`.
    const RasterF* edges = nullptr;  ///< edge_strength.
    std::vector<Vec2d> outline;      ///< x / z and y / z in the color camera's axes.
};

/// Adds points in the color camera's axes to the view's outline; points behind the camera are left out.
void add_outline(EdgeView& view, const std::vector<Vec3d>& points);

/// Per view: mean strength of the edges at the outline, less 1; 0 where outline and picture have nothing to do with each other,
/// for points outside the picture, and for views with fewer than 20 points.
std::vector<double> edge_responses(const std::vector<EdgeView>& views, const CameraChange& change);

/// Mean over the views with at least 20 points; 0 without any. At least half of the views count.
double edge_response(const std::vector<EdgeView>& views, const CameraChange& change);

/// A focal length is looked for up to this natural logarithm of its factor, and a little beyond by finer steps.
inline constexpr double color_focal_reach = 0.3;

/// The strongest response around `start`: focal lengths up to 35 % off, shifts up to 4 % of the picture. Throws Canceled.
CameraChange best_change(const std::vector<EdgeView>& views, const CameraChange& start, const Progress& progress);

}  // namespace fresco::inspect
