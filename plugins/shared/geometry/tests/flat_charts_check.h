#pragma once

#include "catch.h"

#include <fresco/geometry/flatten.h>

#include <algorithm>
#include <set>

inline std::size_t charts_of(const fresco::geometry::FlatCharts& flat)
{
    return std::set<std::uint32_t>(flat.chart_of_face.begin(), flat.chart_of_face.end()).size();
}

inline bool overlap_free(const fresco::geometry::FlatCharts& flat, double tolerance = 1e-6)
{
    for (const auto& faces : flat.faces())
        if (!fresco::geometry::find_overlaps(flat.corners, faces, tolerance).empty())
            return false;
    return true;
}

/// Every face projected to the xy plane, in the chart that `chart_of` says.
template <class ChartOf>
fresco::geometry::FlatCharts seen_from_above(const fresco::Mesh& mesh, ChartOf chart_of)
{
    fresco::geometry::FlatCharts flat;
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
    {
        flat.chart_of_face.push_back(chart_of(f));
        for (const auto v : mesh.triangles[f])
            flat.corners.push_back({mesh.positions[v].x, mesh.positions[v].y});
    }
    flat.projected.assign(mesh.triangles.size(), 1);
    flat.axes.assign(std::size_t{std::ranges::max(flat.chart_of_face)} + 1, fresco::Vec3d{0, 0, 1});
    return flat;
}

/// The area of a face in its chart over that on the surface.
inline double share_of(const fresco::geometry::Surface& surface, const fresco::geometry::FlatCharts& flat, std::size_t f)
{
    const auto* c = &flat.corners[3 * f];
    return 0.5 * cross(c[1] - c[0], c[2] - c[0]) / surface.areas[f];
}
