#pragma once

#include <fresco/geometry/topology.h>
#include <fresco/parallel.h>

#include <cstdint>
#include <vector>

/// \file Cutting a surface into charts, connected sets of faces that look roughly the same way: how every atlas begins.

namespace fresco::geometry
{

/// A mesh with what chart growing asks of it again and again. Refers to the mesh, which must outlive it.
struct Surface
{
    const Mesh& mesh;
    Neighbors neighbors;
    std::vector<double> areas;   ///< F, square meters.
    std::vector<Vec3d> normals;  ///< F, unit; zero for faces without area.

    explicit Surface(const Mesh& of);
};

/// A chart of at most this many faces may be a crumb: noise of the scan, which may go into another chart.
inline constexpr std::size_t crumb_faces = 64;

struct ChartOptions
{
    double angle_limit_deg;  ///< Largest angle between the smoothed normal of a face and its chart's axis.
    double merge_limit_deg;  ///< Limit for the true normals, and for crumbs that join a neighbor.
};

/// A partition of the faces. `none` in chart_of_face: not in a chart yet.
struct Partition
{
    std::vector<std::uint32_t> chart_of_face;  ///< F
    std::vector<Vec3d> axes;                   ///< One unit vector per chart: the area-weighted mean normal when it was grown.

    /// The faces of every chart, ascending.
    std::vector<std::vector<std::uint32_t>> faces() const;
};

/// The charts that share edges with these faces of one chart, longest common border first.
std::vector<std::uint32_t> charts_beside(const Surface& surface, const std::vector<std::uint32_t>& chart_of_face,
                                         const std::vector<std::uint32_t>& faces);

/// Numbers charts by their first faces, and leaves no number without faces.
void renumber_charts(std::vector<std::uint32_t>& chart_of_face, std::vector<Vec3d>& axes);

/// Face normals averaged over about ten rings without rounding edges off: neighbors count by area and by how well they agree.
std::vector<Vec3d> smoothed_normals(const Surface& surface, const Progress& progress);

/// Adds charts until every face has one: seeds in the order of how much area looks their way, grown over the surface while the
/// given normals stay within the limit of the chart's mean.
void grow_charts(const Surface& surface, const std::vector<Vec3d>& normals, double angle_limit_deg, Partition& partition,
                 const Progress& progress);

/// Joins charts with a larger neighbor whose axis suits all their faces: any chart within angle_limit_deg by `normals`, crumbs
/// of a few faces within merge_limit_deg by the true normals. Charts are renumbered without gaps.
void merge_charts(const Surface& surface, const std::vector<Vec3d>& normals, const ChartOptions& options, Partition& partition,
                  const Progress& progress);

/// All of the above. Every face has a chart; deterministic.
Partition cut_into_charts(const Surface& surface, const ChartOptions& options, const Progress& progress);

}  // namespace fresco::geometry
