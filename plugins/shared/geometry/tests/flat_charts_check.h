#pragma once

#include <fresco/geometry/flatten.h>

#include <set>

inline std::size_t charts_of(const fresco::geometry::FlatCharts& flat)
{
    return std::set<std::uint32_t>(flat.chart_of_face.begin(), flat.chart_of_face.end()).size();
}

inline bool overlap_free(const fresco::geometry::FlatCharts& flat, double tolerance = 1e-6)
{
    for (const auto& faces : fresco::geometry::Partition{flat.chart_of_face, flat.axes}.faces())
        if (!find_overlaps(flat.corners, faces, tolerance).empty())
            return false;
    return true;
}
