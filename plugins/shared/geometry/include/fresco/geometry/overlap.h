#pragma once

#include <fresco/geometry/topology.h>

#include <span>
#include <utility>
#include <vector>

/// \file Faces of one flattened chart that lie on each other.

namespace fresco::geometry
{

/// Corner k of face f of a flattened mesh is at corners[3 * f + k].
using Corners = std::vector<Vec2d>;

/// How deep two triangles reach into each other: the smallest shift that parts them (0 if they only touch or are apart). Any
/// orientation; a triangle without area has depth 0 with everything it does not cross.
double overlap_depth(std::span<const Vec2d, 3> a, std::span<const Vec2d, 3> b);

/// All pairs (first < second, ascending) of the listed faces whose overlap is deeper than `tolerance`, by a grid of cells.
std::vector<std::pair<std::uint32_t, std::uint32_t>> find_overlaps(const Corners& corners, std::span<const std::uint32_t> faces,
                                                                   double tolerance);

}  // namespace fresco::geometry
