#pragma once

#include <fresco/geometry/charts.h>
#include <fresco/progress.h>

#include <cstdint>
#include <vector>

/// A connected piece of the surface that is nearly plane.
struct PlaneSegment
{
    std::vector<std::uint32_t> faces;  ///< In the order in which they were reached.
    fresco::Vec3d normal;              ///< Unit length, to the side that the faces face.
    fresco::Vec3d middle;              ///< Mean by area; on the plane.
    double area = 0;

    double distance(fresco::Vec3d point) const { return dot(normal, point - middle); }
};

struct PlaneLimits
{
    double angle_deg = 20;     ///< Between a face's smoothed normal and the plane's.
    double distance_m = 0.03;  ///< Of a face's middle from the plane.
    double least_area_m2 = 0.02;
};

/// Grows planes over the surface: from the flattest faces outward, each plane fitted again (least squares) whenever it has
/// doubled. Faces of smaller pieces are in none. `normals`: as geometry::smoothed_normals gives them. The same for any number of
/// threads. Throws Canceled. Rabbani, van den Heuvel and Vosselman, "Segmentation of point clouds using smoothness constraint"
/// (2006), on faces instead of points.
std::vector<PlaneSegment> plane_segments(const fresco::geometry::Surface& surface, const std::vector<fresco::Vec3d>& normals,
                                         const PlaneLimits& limits, const fresco::Progress& progress);

/// The mean of a face's corners.
fresco::Vec3d face_middle(const fresco::Mesh& mesh, std::size_t face);
