#include "lscm.h"

#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_parameterization/LSCM_parameterizer_3.h>
#include <CGAL/Surface_mesh_parameterization/parameterize.h>

namespace smp = CGAL::Surface_mesh_parameterization;

std::optional<std::vector<fresco::Vec2d>> lscm_map(const fresco::geometry::Disk& disk)
{
    using Kernel = CGAL::Simple_cartesian<double>;
    using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
    SurfaceMesh mesh;
    std::vector<SurfaceMesh::Vertex_index> vertices;
    vertices.reserve(disk.points.size());
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
    places.reserve(vertices.size());
    for (const auto v : vertices)
        places.push_back({uv[v].x(), uv[v].y()});
    return places;
}
