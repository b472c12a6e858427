#include "holes.h"

#include <CGAL/Polygon_mesh_processing/fair.h>
#include <CGAL/Polygon_mesh_processing/refine.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <fresco/geometry/topology.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

using namespace fresco;

namespace
{

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;
namespace pmp = CGAL::Polygon_mesh_processing;

constexpr std::size_t most_loop_vertices = 2000;
/// Loop and neighbors within this share of the loop's width of a plane: the patch stays flat.
constexpr double flat_share = 0.02;
constexpr std::size_t most_points = 32;
/// Surface this much farther away than a patch, or this share of its distance, lies behind it.
constexpr double behind_m = 0.05;
constexpr double behind_share = 0.03;
constexpr double opening_share = 0.2;
constexpr std::size_t least_looks = 8;

Vec3d place(const Mesh& mesh, std::uint32_t vertex)
{
    return vec_cast<double>(mesh.positions[vertex]);
}

/// Halfedge 3f + k goes from corner k of face f to the next corner.
class HalfEdges
{
  public:
    static constexpr std::int64_t boundary = -1;
    static constexpr std::int64_t many_faces = -2;

    explicit HalfEdges(const Mesh& mesh) : mesh_(mesh), twins_(3 * mesh.triangles.size(), boundary)
    {
        const auto halfedge = [](const geometry::EdgeUse& use) { return 3 * std::int64_t{use.face} + use.corner; };
        geometry::for_each_edge(mesh.triangles, mesh.positions.size(),
                                [&](std::uint32_t, std::uint32_t, std::span<const geometry::EdgeUse> uses)
                                {
                                    const bool are_twins = uses.size() == 2 && uses[0].forward != uses[1].forward;
                                    for (std::size_t i = 0; uses.size() > 1 && i < uses.size(); ++i)
                                        twins_[static_cast<std::size_t>(halfedge(uses[i]))] =
                                            are_twins ? halfedge(uses[1 - i]) : many_faces;
                                });
    }

    std::size_t size() const { return twins_.size(); }
    std::uint32_t from(std::size_t h) const { return mesh_.triangles[h / 3][h % 3]; }
    std::uint32_t to(std::size_t h) const { return mesh_.triangles[h / 3][(h + 1) % 3 == 0 ? 0 : h % 3 + 1]; }
    std::uint32_t opposite(std::size_t h) const { return from(previous(h)); }
    static std::size_t previous(std::size_t h) { return h / 3 * 3 + (h % 3 + 2) % 3; }
    std::int64_t twin(std::size_t h) const { return twins_[h]; }

    /// The boundary halfedge that ends where `h`, one of them, begins, in the same fan of faces; -1 where the fan ends at an edge
    /// of many faces.
    std::int64_t next_on_boundary(std::size_t h) const
    {
        std::size_t at = previous(h);
        while (twins_[at] >= 0)
            at = previous(static_cast<std::size_t>(twins_[at]));
        return twins_[at] == boundary ? static_cast<std::int64_t>(at) : -1;
    }

  private:
    const Mesh& mesh_;
    std::vector<std::int64_t> twins_;
};

/// Boundary halfedges around a hole. The faces that fill it run through their ends in this order.
using Loop = std::vector<std::size_t>;

/// Parts of a loop that meets itself at a vertex: each passes a vertex once.
std::vector<Loop> simple_loops(const HalfEdges& edges, const Loop& loop)
{
    std::vector<Loop> result;
    Loop open;
    std::map<std::uint32_t, std::size_t> place_of;
    for (const std::size_t h : loop)
    {
        if (const auto seen = place_of.find(edges.to(h)); seen != place_of.end())
        {
            const std::size_t begin = seen->second;
            Loop part(open.begin() + static_cast<std::ptrdiff_t>(begin), open.end());
            open.resize(begin);
            for (const std::size_t other : part)
                place_of.erase(edges.to(other));
            result.push_back(std::move(part));
        }
        place_of[edges.to(h)] = open.size();
        open.push_back(h);
    }
    result.push_back(std::move(open));
    std::erase_if(result, [](const Loop& part) { return part.size() < 3; });
    return result;
}

std::vector<Loop> find_loops(const HalfEdges& edges, HoleFigures& figures)
{
    std::vector<Loop> result;
    std::vector<bool> is_done(edges.size());
    for (std::size_t first = 0; first < edges.size(); ++first)
    {
        if (edges.twin(first) != HalfEdges::boundary || is_done[first])
            continue;
        Loop loop;
        auto at = static_cast<std::int64_t>(first);
        while (at >= 0 && !is_done[static_cast<std::size_t>(at)])
        {
            is_done[static_cast<std::size_t>(at)] = true;
            loop.push_back(static_cast<std::size_t>(at));
            at = edges.next_on_boundary(static_cast<std::size_t>(at));
        }
        if (at != static_cast<std::int64_t>(first))
            ++figures.failed;
        else
            for (Loop& part : simple_loops(edges, loop))
                result.push_back(std::move(part));
    }
    return result;
}

/// The largest distance between two of its vertices; some number above `limit` where that is larger.
double width_of(const Mesh& mesh, const HalfEdges& edges, const Loop& loop, double limit)
{
    double widest = 0;
    for (std::size_t i = 0; i < loop.size() && widest <= limit; ++i)
        for (std::size_t k = 0; k < i; ++k)
            widest = std::max(widest, length(place(mesh, edges.to(loop[i])) - place(mesh, edges.to(loop[k]))));
    return widest;
}

/// Whether most of the faces along the loop lie inside of it, seen along its normal: it bounds a small piece from outside.
bool is_outer(const Mesh& mesh, const HalfEdges& edges, const Loop& loop)
{
    Vec3d normal;
    for (const std::size_t h : loop)
        normal += cross(place(mesh, edges.to(h)), place(mesh, edges.from(h)));
    double inside = 0;
    double all = 0;
    for (const std::size_t h : loop)
    {
        const Vec3d edge = place(mesh, edges.from(h)) - place(mesh, edges.to(h));
        const Vec3d to_face = place(mesh, edges.opposite(h)) - place(mesh, edges.to(h));
        all += length(edge);
        inside += dot(cross(normal, edge), to_face) > 0 ? length(edge) : 0;
    }
    return inside > 0.5 * all;
}

Point point(Vec3d p)
{
    return {p.x, p.y, p.z};
}

Vec3d vector(const Point& p)
{
    return {p.x(), p.y(), p.z()};
}

bool is_flat(const Mesh& mesh, const HalfEdges& edges, const Loop& loop, double width_m)
{
    Vec3d normal;
    Vec3d middle;
    for (const std::size_t h : loop)
    {
        normal += cross(place(mesh, edges.to(h)), place(mesh, edges.from(h)));
        middle += place(mesh, edges.to(h)) * (1.0 / static_cast<double>(loop.size()));
    }
    normal = normalized(normal);
    return std::ranges::all_of(loop,
                               [&](std::size_t h)
                               {
                                   const auto apart = [&](std::uint32_t vertex)
                                   { return std::abs(dot(place(mesh, vertex) - middle, normal)); };
                                   return std::max(apart(edges.to(h)), apart(edges.opposite(h))) <= flat_share * width_m;
                               });
}

/// The faces around the loop, two rings wide, that a patch bends on from.
std::vector<std::size_t> faces_around(const HalfEdges& edges, const Loop& loop)
{
    std::vector<std::size_t> faces;
    for (const std::size_t h : loop)
    {
        // All faces around the vertex where it begins, from one side to the other.
        faces.push_back(h / 3);
        for (std::size_t at = HalfEdges::previous(h); edges.twin(at) >= 0;)
        {
            const auto other = static_cast<std::size_t>(edges.twin(at));
            faces.push_back(other / 3);
            at = HalfEdges::previous(other);
        }
    }
    const std::size_t first_ring = faces.size();
    for (std::size_t i = 0; i < first_ring; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            if (const std::int64_t twin = edges.twin(3 * faces[i] + k); twin >= 0)
                faces.push_back(static_cast<std::size_t>(twin) / 3);
    std::ranges::sort(faces);
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    return faces;
}

/// A surface of the triangles over the loop, and around it those of `around`, where together they are a manifold.
class LocalSurface
{
  public:
    LocalSurface(const Mesh& mesh, const HalfEdges& edges, const Loop& loop, const std::vector<Triangle>& filling,
                 const std::vector<std::size_t>& around)
    {
        std::map<std::uint32_t, Surface::Vertex_index> vertex_of;
        const auto vertex = [&](std::uint32_t v)
        {
            const auto [found, is_new] = vertex_of.try_emplace(v);
            if (is_new)
                found->second = surface.add_vertex(point(place(mesh, v)));
            return found->second;
        };
        for (const std::size_t h : loop)
            (void)vertex(edges.to(h));
        for (const std::size_t face : around)
        {
            const Triangle& t = mesh.triangles[face];
            is_manifold = is_manifold && surface.add_face(vertex(t[0]), vertex(t[1]), vertex(t[2])) != Surface::null_face();
        }
        for (const Triangle& t : filling)
        {
            const auto at = [](std::uint32_t i) { return Surface::Vertex_index(i); };
            faces.push_back(surface.add_face(at(t[0]), at(t[1]), at(t[2])));
            is_manifold = is_manifold && faces.back() != Surface::null_face();
        }
    }

    Surface surface;
    std::vector<Surface::Face_index> faces;  ///< Faces of the filling.
    bool is_manifold = true;
};

HolePatch patch_of(const Mesh& mesh, const HalfEdges& edges, const Loop& loop, double width_m)
{
    std::vector<Point> polyline;
    std::vector<Point> beyond;
    for (const std::size_t h : loop)
    {
        polyline.push_back(point(place(mesh, edges.to(h))));
        beyond.push_back(point(place(mesh, edges.opposite(h))));
    }
    std::vector<CGAL::Triple<int, int, int>> triples;
    pmp::triangulate_hole_polyline(polyline, beyond, std::back_inserter(triples));
    HolePatch patch;
    for (const std::size_t h : loop)
        patch.loop.push_back(edges.to(h));
    std::vector<Triangle> filling;
    for (const auto& triple : triples)
    {
        Triangle t{static_cast<std::uint32_t>(triple.first), static_cast<std::uint32_t>(triple.second),
                   static_cast<std::uint32_t>(triple.third)};
        std::ranges::sort(t);  // As the loop runs.
        filling.push_back(t);
    }
    if (filling.size() + 2 != loop.size())
        return patch;

    const bool is_smooth = !is_flat(mesh, edges, loop, width_m);
    LocalSurface local(mesh, edges, loop, filling, is_smooth ? faces_around(edges, loop) : std::vector<std::size_t>{});
    const bool bends_on = is_smooth && local.is_manifold;
    if (!local.is_manifold)
        local = LocalSurface(mesh, edges, loop, filling, {});
    if (!local.is_manifold)
        return patch;
    std::vector<Surface::Face_index> new_faces;
    std::vector<Surface::Vertex_index> new_vertices;
    pmp::refine(local.surface, local.faces, std::back_inserter(new_faces), std::back_inserter(new_vertices));
    if (is_smooth && !new_vertices.empty())
        pmp::fair(local.surface, new_vertices, CGAL::parameters::fairing_continuity(bends_on ? 1 : 0));

    std::map<Surface::Vertex_index, std::uint32_t> number_of;
    for (const Surface::Vertex_index v : new_vertices)
    {
        number_of[v] = static_cast<std::uint32_t>(loop.size() + patch.added.size());
        patch.added.push_back(vector(local.surface.point(v)));
    }
    local.faces.insert(local.faces.end(), new_faces.begin(), new_faces.end());
    for (const Surface::Face_index face : local.faces)
    {
        Triangle t{};
        std::size_t corner = 0;
        for (const Surface::Vertex_index v : local.surface.vertices_around_face(local.surface.halfedge(face)))
        {
            const auto added = number_of.find(v);
            t[corner++] = added != number_of.end() ? added->second : static_cast<std::uint32_t>(v);
        }
        patch.faces.push_back(t);
    }
    const auto corner = [&](std::uint32_t i)
    { return i < loop.size() ? place(mesh, patch.loop[i]) : patch.added[i - loop.size()]; };
    for (std::size_t i = 0; i < patch.faces.size(); i += 1 + patch.faces.size() / most_points)
    {
        const Triangle& t = patch.faces[i];
        patch.points.push_back((corner(t[0]) + corner(t[1]) + corner(t[2])) * (1.0 / 3));
    }
    return patch;
}

Rgb8 color_of(const Mesh& mesh, const std::vector<std::uint32_t>& loop, Vec3d at)
{
    Vec3d sum;
    double weights = 0;
    for (const std::uint32_t vertex : loop)
    {
        const Vec3d apart = place(mesh, vertex) - at;
        const double weight = 1 / std::max(dot(apart, apart), 1e-12);
        const Rgb8& color = mesh.colors[vertex];
        sum += Vec3d{double(color[0]), double(color[1]), double(color[2])} * weight;
        weights += weight;
    }
    const auto rounded = [&](double v) { return static_cast<std::uint8_t>(std::lround(v / weights)); };
    return {rounded(sum.x), rounded(sum.y), rounded(sum.z)};
}

}  // namespace

bool HolePatch::is_opening() const
{
    const auto through = static_cast<double>(looks_through);
    return looks_through >= least_looks && through > opening_share * (through + static_cast<double>(looks_onto));
}

std::vector<HolePatch> hole_patches(const Mesh& mesh, double max_width_m, Progress& progress, HoleFigures& figures)
{
    const HalfEdges edges(mesh);
    progress.check_canceled();
    std::vector<Loop> loops = find_loops(edges, figures);
    std::vector<double> widths;
    std::erase_if(loops,
                  [&](const Loop& loop)
                  {
                      const double width =
                          loop.size() > most_loop_vertices ? 2 * max_width_m + 1 : width_of(mesh, edges, loop, max_width_m);
                      const bool is_outside = width <= max_width_m && is_outer(mesh, edges, loop);
                      figures.too_large += width > max_width_m ? 1 : 0;
                      figures.outer += is_outside ? 1 : 0;
                      if (width > max_width_m || is_outside)
                          return true;
                      widths.push_back(width);
                      return false;
                  });
    std::vector<HolePatch> patches(loops.size());
    parallel_for_each(loops.size(), "holes", progress,
                      [&](std::size_t i) { patches[i] = patch_of(mesh, edges, loops[i], widths[i]); });
    figures.failed += std::erase_if(patches, [](const HolePatch& patch) { return patch.faces.empty(); });
    return patches;
}

void judge(std::span<HolePatch> patches, const Camera& camera, const RasterF& depth_m)
{
    for (HolePatch& patch : patches)
        for (const Vec3d& point : patch.points)
        {
            const Vec3d seen = camera.project(point);
            if (seen.z <= 0 || seen.x < 0 || seen.y < 0 || seen.x >= depth_m.width || seen.y >= depth_m.height)
                continue;
            const double measured = depth_m.at(static_cast<int>(seen.x), static_cast<int>(seen.y));
            const double margin = std::max(behind_m, behind_share * seen.z);
            if (measured > 0 && measured > seen.z - margin)
                ++(measured > seen.z + margin ? patch.looks_through : patch.looks_onto);
        }
}

Mesh with_patches(const Mesh& mesh, std::span<const HolePatch> patches, HoleFigures& figures)
{
    Mesh result = mesh;
    result.texcoords.clear();
    result.charts.clear();
    for (const HolePatch& patch : patches)
    {
        if (patch.is_opening())
        {
            ++figures.openings;
            continue;
        }
        ++figures.closed;
        const auto first = static_cast<std::uint32_t>(result.positions.size());
        for (const Vec3d& added : patch.added)
        {
            result.positions.push_back(vec_cast<float>(added));
            if (!mesh.colors.empty())
                result.colors.push_back(color_of(mesh, patch.loop, added));
        }
        for (const Triangle& t : patch.faces)
        {
            Triangle face{};
            for (std::size_t corner = 0; corner < 3; ++corner)
                face[corner] = t[corner] < patch.loop.size() ? patch.loop[t[corner]]
                                                             : first + t[corner] - static_cast<std::uint32_t>(patch.loop.size());
            result.triangles.push_back(face);
            figures.area_m2 += 0.5 * length(cross(place(result, face[1]) - place(result, face[0]),
                                                  place(result, face[2]) - place(result, face[0])));
        }
        figures.faces_added += patch.faces.size();
    }
    return result;
}
