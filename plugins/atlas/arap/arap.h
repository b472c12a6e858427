#pragma once

#include <fresco/geometry/charts.h>

#include <optional>
#include <vector>

/// Lays a disk, maybe with holes, flat as rigidly as it can (ARAP of Liu et al., "A local/global approach to mesh
/// parameterization", SGP 2008, section 4.2, with positive weights): rotations of the single faces and one global solve in turn,
/// from the places given. One place per point, at the surface's scale; nothing if the solver gives up. Callable from any thread.
std::optional<std::vector<fresco::Vec2d>> arap_map(const fresco::geometry::Disk& disk, const std::vector<fresco::Vec2d>& from);
