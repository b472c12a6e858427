#pragma once

#include "projection.h"

#include <array>
#include <span>

namespace raster
{

/// The part of a triangle that lies before the near plane and between the frustum's outer planes.
struct Clipped
{
    /// One more than a triangle's for each of the five planes; rounding may bend the polygon, whence half as many more each.
    static constexpr std::size_t most_corners = 19;

    std::array<Projected, most_corners> corners;
    std::size_t count = 0;  ///< 0: nothing is left.
};

/// Cuts a triangle, given in the camera's frame, plane by plane (Sutherland and Hodgman, "Reentrant polygon clipping", 1974). Two
/// triangles that share an edge get equal corners on it, bit by bit.
Clipped clipped(const std::array<fresco::Vec3d, 3>& triangle, const Frustum& frustum);

}  // namespace raster
