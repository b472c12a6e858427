#include "decimations.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_policies.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/version.h>

namespace bench
{
namespace
{

namespace simplification = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

struct StopAtFaces
{
    std::size_t target;
    const Surface* surface;
    template <class Cost, class Profile>
    bool operator()(const Cost&, const Profile&, std::size_t, std::size_t) const
    {
        return surface->number_of_faces() <= target;
    }
};

Surface surface_of(const fresco::Mesh& mesh)
{
    Surface surface;
    for (const auto& p : mesh.positions)
        surface.add_vertex(Kernel::Point_3(p.x, p.y, p.z));
    for (const auto& t : mesh.triangles)
        surface.add_face(Surface::Vertex_index(t[0]), Surface::Vertex_index(t[1]), Surface::Vertex_index(t[2]));
    return surface;
}

fresco::Mesh mesh_of(Surface& surface)
{
    surface.collect_garbage();
    fresco::Mesh mesh;
    for (const auto v : surface.vertices())
    {
        const auto& p = surface.point(v);
        mesh.positions.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
    }
    for (const auto f : surface.faces())
    {
        fresco::Triangle triangle{};
        std::size_t k = 0;
        for (const auto v : CGAL::vertices_around_face(surface.halfedge(f), surface))
            triangle[k++] = static_cast<std::uint32_t>(v);
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

fresco::Mesh lindstrom_turk(const fresco::Mesh& mesh, std::size_t target, fresco::Progress&)
{
    Surface surface = surface_of(mesh);
    simplification::edge_collapse(surface, StopAtFaces{target, &surface},
                                  CGAL::parameters::get_cost(simplification::LindstromTurk_cost<Surface>())
                                      .get_placement(simplification::LindstromTurk_placement<Surface>()));
    return mesh_of(surface);
}

fresco::Mesh garland_heckbert(const fresco::Mesh& mesh, std::size_t target, fresco::Progress&)
{
    Surface surface = surface_of(mesh);
    const simplification::GarlandHeckbert_policies<Surface, Kernel> policies(surface);
    simplification::edge_collapse(surface, StopAtFaces{target, &surface},
                                  CGAL::parameters::get_cost(policies.get_cost()).get_placement(policies.get_placement()));
    return mesh_of(surface);
}

}  // namespace

std::vector<Decimation> cgal_decimations()
{
    return {{"CGAL " CGAL_VERSION_STR " Lindstrom-Turk", lindstrom_turk},
            {"CGAL " CGAL_VERSION_STR " Garland-Heckbert", garland_heckbert}};
}

}  // namespace bench
