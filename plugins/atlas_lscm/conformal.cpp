#include "conformal.h"

#include <fresco/parallel.h>

#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_parameterization/LSCM_parameterizer_3.h>
#include <CGAL/Surface_mesh_parameterization/parameterize.h>

#include <atomic>
#include <cmath>

namespace smp = CGAL::Surface_mesh_parameterization;
using namespace fresco::geometry;

namespace
{

using Kernel = CGAL::Simple_cartesian<double>;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

constexpr double smallest_area_share = 0.02;

double area_of(const Disk& disk, const fresco::Triangle& t)
{
    const auto a = disk.points[t[0]];
    return 0.5 * length(cross(disk.points[t[1]] - a, disk.points[t[2]] - a));
}

double area_of(const std::vector<fresco::Vec2d>& places, const fresco::Triangle& t)
{
    return 0.5 * cross(places[t[1]] - places[t[0]], places[t[2]] - places[t[0]]);
}

bool is_good(const Disk& disk, const std::vector<fresco::Vec2d>& places, double tolerance)
{
    Corners corners;
    std::vector<std::uint32_t> all;
    for (const auto& t : disk.triangles)
    {
        if (area_of(places, t) < smallest_area_share * area_of(disk, t))
            return false;
        all.push_back(static_cast<std::uint32_t>(all.size()));
        for (const auto v : t)
            corners.push_back(places[v]);
    }
    return find_overlaps(corners, all, tolerance).empty();
}

}  // namespace

std::optional<std::vector<fresco::Vec2d>> conformal_map(const Disk& disk)
{
    SurfaceMesh mesh;
    std::vector<SurfaceMesh::Vertex_index> vertices;
    for (const auto& p : disk.points)
        vertices.push_back(mesh.add_vertex({p.x, p.y, p.z}));
    for (const auto& t : disk.triangles)
        if (mesh.add_face(vertices[t[0]], vertices[t[1]], vertices[t[2]]) == SurfaceMesh::null_face())
            return std::nullopt;
    const auto border = CGAL::Polygon_mesh_processing::longest_border(mesh).first;
    if (border == SurfaceMesh::null_halfedge())
        return std::nullopt;
    auto uv = mesh.add_property_map<SurfaceMesh::Vertex_index, Kernel::Point_2>("v:uv").first;
    if (smp::parameterize(mesh, smp::LSCM_parameterizer_3<SurfaceMesh>(), border, uv) != smp::OK)
        return std::nullopt;

    std::vector<fresco::Vec2d> places;
    for (const auto v : vertices)
        places.push_back({uv[v].x(), uv[v].y()});
    double on_surface = 0;
    double laid = 0;
    for (const auto& t : disk.triangles)
    {
        on_surface += area_of(disk, t);
        laid += area_of(places, t);
    }
    if (!(laid > 0) || !std::isfinite(laid))
        return std::nullopt;
    const double scale = std::sqrt(on_surface / laid);
    for (auto& p : places)
        p = p * scale;
    return places;
}

ConformalCounts lay_conformal(const Surface& surface, FlatCharts& flat, double tolerance_m, fresco::Progress& progress)
{
    const auto lists = Partition{flat.chart_of_face, flat.axes}.faces();
    std::vector<ConformalCounts> counts(lists.size());
    std::atomic<std::size_t> done{0};
    fresco::parallel_for(lists.size(), 1, progress.threads(),
                         [&](std::size_t begin, std::size_t end)
                         {
                             for (auto c = begin; c < end; ++c)
                             {
                                 progress.check_cancelled();
                                 const auto& faces = lists[c];
                                 done += faces.size();
                                 counts[c].single_triangles = faces.size() == 1 ? 1 : 0;
                                 if (faces.size() < 2)
                                     continue;
                                 const auto disk = cut_to_disk(surface, faces);
                                 const auto places = conformal_map(disk);
                                 if (!places || !is_good(disk, *places, tolerance_m))
                                 {
                                     counts[c].fallbacks = 1;
                                     continue;
                                 }
                                 counts[c].conformal = 1;
                                 counts[c].cut_edges = disk.cut_edges;
                                 for (std::size_t i = 0; i < faces.size(); ++i)
                                 {
                                     flat.projected[faces[i]] = 0;
                                     counts[c].conformal_area_share += surface.areas[faces[i]];
                                     for (std::size_t k = 0; k < 3; ++k)
                                         flat.corners[3 * std::size_t{faces[i]} + k] = (*places)[disk.triangles[i][k]];
                                 }
                                 progress.progress(static_cast<double>(done), static_cast<double>(surface.areas.size()), "faces");
                             }
                         });
    ConformalCounts total;
    double area = 0;
    for (const auto a : surface.areas)
        area += a;
    for (const auto& c : counts)
    {
        total.conformal += c.conformal;
        total.fallbacks += c.fallbacks;
        total.single_triangles += c.single_triangles;
        total.cut_edges += c.cut_edges;
        total.conformal_area_share += area > 0 ? c.conformal_area_share / area : 0;
    }
    return total;
}
