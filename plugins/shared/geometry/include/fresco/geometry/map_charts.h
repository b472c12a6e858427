#pragma once

#include <fresco/geometry/charts.h>
#include <fresco/geometry/flatten.h>
#include <fresco/run_context.h>

#include <functional>
#include <optional>
#include <string>

/// \file Charts laid flat by a parametrization in place of projection, whatever the parametrization.

namespace fresco::geometry
{

/// Lays a disk, maybe with holes, flat, from where its points lie in projection: one place per point, at any scale; nothing if it
/// cannot. Called from several threads.
using DiskMap = std::function<std::optional<std::vector<Vec2d>>(const Disk& disk, const std::vector<Vec2d>& projected)>;

/// How the charts were laid flat.
struct MapCounts
{
    std::size_t mapped_charts = 0;
    std::size_t projected_charts = 0;  ///< Left as they were: the map failed, or stretched, squeezed or folded too much.
    std::size_t single_triangles = 0;  ///< Charts of one face, for which projection is exact.
    std::size_t halved_charts = 0;     ///< Did not fit as a whole and were cut in two.
    std::size_t cut_edges = 0;         ///< Inside mapped charts that are closed or have handles.
    std::size_t cut_off_faces = 0;     ///< Overlapped others, or were squeezed, in a map that was kept without them.
    double mapped_area_share = 0;      ///< Share of the surface in mapped charts.
};

/// Replaces the projection of every chart by its map. Folded faces are relaxed with the faces around them; those that stay
/// folded, keep less than a twentieth of their area, or overlap others are cut off (and have no chart then). A map that loses
/// more than a tenth of the chart so, or whose L² stretch exceeds 1.2, is dropped: the chart is cut in two halves that are tried
/// again, down to 64 faces; what still fails stays projected. The same result for any number of threads. Throws Canceled.
MapCounts map_charts(const Surface& surface, FlatCharts& flat, const DiskMap& map, double tolerance_m, Progress& progress);

/// Enters them into a stage's report.
void report_mapping(RunContext& run, const MapCounts& counts);

}  // namespace fresco::geometry
