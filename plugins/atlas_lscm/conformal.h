#pragma once

#include "disk.h"

#include <fresco/progress.h>

#include <cstddef>
#include <optional>
#include <vector>

/// Lays a disk flat with the least squares conformal map (Lévy et al., "Least squares conformal maps for automatic texture atlas
/// generation", SIGGRAPH 2002), scaled to the disk's area on the surface. One place per point; nothing if the solver gives up.
std::optional<std::vector<fresco::Vec2d>> conformal_map(const Disk& disk);

/// How the charts of an atlas were laid flat.
struct ConformalCounts
{
    std::size_t conformal = 0;         ///< Charts laid by conformal_map.
    std::size_t fallbacks = 0;         ///< Charts left projected: the map folded, overlapped or squeezed a face.
    std::size_t single_triangles = 0;  ///< Charts of one face, for which projection is exact.
    double conformal_area_share = 0;   ///< Of the surface: what lies in conformal charts.
    std::size_t cut_edges = 0;         ///< Edges inside the conformal charts along which they were cut.
};

/// Replaces the projection of every chart by its conformal map where that map is injective and leaves each face a fiftieth of its
/// area. Overlaps up to `tolerance_m` are rounding. The same result for any number of threads. Throws Cancelled.
ConformalCounts lay_conformal(const fresco::geometry::Surface& surface, fresco::geometry::FlatCharts& flat, double tolerance_m,
                              fresco::Progress& progress);
