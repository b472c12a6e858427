#pragma once

#include "catch.h"

#include <fresco/geometry/flatten.h>

#include <numeric>
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

/// All faces of a mesh, cut open where they make no disk.
inline fresco::geometry::Disk whole_disk(const fresco::Mesh& mesh)
{
    std::vector<std::uint32_t> faces(mesh.triangles.size());
    std::iota(faces.begin(), faces.end(), 0u);
    return cut_to_disk(fresco::geometry::Surface(mesh), faces);
}

/// The edges of a disk in the plane are `scale` times as long as on the surface, within this share.
inline void check_lengths(const fresco::geometry::Disk& disk, const std::vector<fresco::Vec2d>& places, double scale,
                          double within)
{
    for (const auto& t : disk.triangles)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto a = t[k], b = t[(k + 1) % 3];
            CHECK(length(places[b] - places[a]) == Approx(scale * length(disk.points[b] - disk.points[a])).epsilon(within));
        }
}
