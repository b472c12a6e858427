#pragma once

#include <fresco/geometry/charts.h>

#include <optional>
#include <vector>

/// Lays a disk, maybe with holes, flat with the least squares conformal map (Lévy et al., "Least squares conformal maps for
/// automatic texture atlas generation", SIGGRAPH 2002). One place per point, at any scale; nothing if the solver gives up.
std::optional<std::vector<fresco::Vec2d>> lscm_map(const fresco::geometry::Disk& disk);
