#pragma once

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
