#pragma once

#include "plane_segments.h"

#include <vector>

/// An upright segment in columns of column_m along it: how much of it there is, and how high it reaches.
struct WallColumns
{
    static constexpr double column_m = 0.1;

    struct Column
    {
        double area = 0;
        double top = 0;        ///< Height of its highest face.
        fresco::Vec3d middle;  ///< Mean by area.
    };

    const PlaneSegment* segment = nullptr;
    fresco::Vec3d along;  ///< Level, in the plane; unit length.
    double first = 0;     ///< Where the first column begins, along `along`.
    std::vector<Column> columns;
    double low = 0;   ///< Height of its lowest face,
    double high = 0;  ///< and of its highest.

    double width() const { return column_m * static_cast<double>(columns.size()); }
    /// Of the column at a point; may lie outside of them.
    long column_at(fresco::Vec3d point) const;
};

/// z is up.
WallColumns wall_columns(const fresco::geometry::Surface& surface, const PlaneSegment& segment);

/// The share of the segment's area in columns behind which another one, that faces the same way, rises higher: that of a
/// cupboard in front of its wall is nearly 1, that of a wall nearly 0.
double overtopped_share(const WallColumns& of, const std::vector<WallColumns>& all);
