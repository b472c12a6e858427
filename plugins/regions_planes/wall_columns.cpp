#include "wall_columns.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace fresco;

namespace
{
/// How far behind a piece of furniture its wall is.
constexpr double nearest_behind_m = 0.05;
constexpr double farthest_behind_m = 1.2;
constexpr double clearly_higher_m = 0.1;
/// Of a segment that counts as a wall behind another.
constexpr double least_area_m2 = 0.1;
constexpr double same_way_cosine = 0.9;
}  // namespace

long WallColumns::column_at(Vec3d point) const
{
    return std::lround(std::floor((dot(along, point) - first) / column_m));
}

WallColumns wall_columns(const geometry::Surface& surface, const PlaneSegment& segment)
{
    WallColumns result;
    result.segment = &segment;
    result.along = normalized(cross(Vec3d{0, 0, 1}, segment.normal));
    double least = std::numeric_limits<double>::max();
    double most = std::numeric_limits<double>::lowest();
    result.low = least;
    result.high = most;
    for (const std::uint32_t f : segment.faces)
    {
        const Vec3d middle = face_middle(surface.mesh, f);
        least = std::min(least, dot(result.along, middle));
        most = std::max(most, dot(result.along, middle));
        result.low = std::min(result.low, middle.z);
        result.high = std::max(result.high, middle.z);
    }
    result.first = least;
    result.columns.resize(static_cast<std::size_t>((most - least) / WallColumns::column_m) + 1);
    for (WallColumns::Column& column : result.columns)
        column.top = std::numeric_limits<double>::lowest();
    for (const std::uint32_t f : segment.faces)
    {
        const Vec3d middle = face_middle(surface.mesh, f);
        WallColumns::Column& column = result.columns[static_cast<std::size_t>(std::max(result.column_at(middle), 0L))];
        column.area += surface.areas[f];
        column.top = std::max(column.top, middle.z);
        column.middle += middle * surface.areas[f];
    }
    for (WallColumns::Column& column : result.columns)
        if (column.area > 0)
            column.middle = column.middle * (1 / column.area);
    return result;
}

double overtopped_share(const WallColumns& of, const std::vector<WallColumns>& all)
{
    std::vector<double> top_behind(of.columns.size(), std::numeric_limits<double>::lowest());
    for (const WallColumns& other : all)
    {
        if (other.segment == of.segment || other.segment->area < least_area_m2 ||
            dot(other.segment->normal, of.segment->normal) < same_way_cosine)
            continue;
        for (const WallColumns::Column& column : other.columns)
        {
            if (!(column.area > 0))
                continue;
            const double behind = -of.segment->distance(column.middle);
            if (behind < nearest_behind_m || behind > farthest_behind_m)
                continue;
            // Columns of both do not begin at the same place.
            const long at = of.column_at(column.middle);
            for (long i = std::max(at - 1, 0L); i <= std::min(at + 1, static_cast<long>(top_behind.size()) - 1); ++i)
                top_behind[static_cast<std::size_t>(i)] = std::max(top_behind[static_cast<std::size_t>(i)], column.top);
        }
    }
    double overtopped = 0;
    double total = 0;
    for (std::size_t i = 0; i < of.columns.size(); ++i)
    {
        total += of.columns[i].area;
        if (top_behind[i] > of.columns[i].top + clearly_higher_m)
            overtopped += of.columns[i].area;
    }
    return total > 0 ? overtopped / total : 0;
}
