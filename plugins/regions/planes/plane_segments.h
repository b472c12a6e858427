#pragma once

#include <fresco/geometry/charts.h>
#include <fresco/parallel.h>

#include <cstdint>
#include <vector>

/// \file Divides a surface into nearly plane segments, and measures upright ones column by column. find_room_parts() chooses
/// floor, ceiling and walls among them.

/// A connected, nearly plane segment of the surface.
struct PlaneSegment
{
    std::vector<std::uint32_t> faces;  ///< In the order in which they were reached.
    fresco::Vec3d normal;              ///< Unit length, to the side that the faces face.
    fresco::Vec3d middle;              ///< Mean by area; on the plane.
    double area = 0;

    double distance(fresco::Vec3d point) const { return dot(normal, point - middle); }
};

/// Limits of a segment.
inline constexpr double most_off_m = 0.03;  ///< Distance of a face's middle from the plane.
inline constexpr double least_segment_m2 = 0.02;

/// A surface with what dividing it asks of it again and again. Refers to the mesh, which must outlive it.
struct SmoothSurface : fresco::geometry::Surface
{
    std::vector<fresco::Vec3d> middles;         ///< F, by face_middle.
    std::vector<fresco::Vec3d> smooth_normals;  ///< F, by geometry::smoothed_normals.

    SmoothSurface(const fresco::Mesh& of, const fresco::Progress& progress);
};

/// Grows planes over the surface: from the flattest faces outward, each plane fitted again (least squares) whenever it has
/// doubled. Faces of smaller segments are in none. The same for any number of threads. Throws Canceled. Rabbani, van den Heuvel
/// and Vosselman, "Segmentation of point clouds using smoothness constraint" (2006), on faces instead of points.
std::vector<PlaneSegment> plane_segments(const SmoothSurface& surface, const fresco::Progress& progress);

/// The mean of a face's corners.
fresco::Vec3d face_middle(const fresco::Mesh& mesh, std::size_t face);

/// The area and height of an upright segment, in columns of column_m along it.
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
    double first = 0;     ///< Start of the first column, along `along`.
    std::vector<Column> columns;
    double low = 0;   ///< Height of its lowest face.
    double high = 0;  ///< Height of its highest face.

    double width() const { return column_m * static_cast<double>(columns.size()); }
    /// The number of the column at a point; may be out of range.
    long column_at(fresco::Vec3d point) const;
};

/// The columns of a segment. z is up.
WallColumns wall_columns(const SmoothSurface& surface, const PlaneSegment& segment);

/// The share of the segment's area in columns with a higher segment behind them that faces the same way: nearly 1 for a cupboard
/// in front of its wall, nearly 0 for a wall.
double overtopped_share(const WallColumns& of, const std::vector<WallColumns>& all);

/// The share of the segment's area in columns with any segment behind them: nearly 1 for furniture, which has a top or a back,
/// nearly 0 for a wall, behind which no camera looked.
double backed_share(const SmoothSurface& surface, const WallColumns& of, const std::vector<PlaneSegment>& segments);
