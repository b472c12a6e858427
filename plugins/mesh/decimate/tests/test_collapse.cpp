#include "catch.h"
#include "collapse.h"
#include "shapes.h"

#include <fresco/geometry/repair.h>
#include <fresco/geometry/topology.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

using fresco::Mesh;
using fresco::Triangle;
using fresco::Vec3d;
using fresco::Vec3f;
using fresco::geometry::count_surface;

namespace
{

std::vector<VertexLoad> loads_of(const Mesh& mesh)
{
    std::vector<VertexLoad> loads(mesh.positions.size());
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t)
            loads[v].normal += cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
    return loads;
}

Piece piece_of(const Mesh& mesh)
{
    return {mesh.positions, loads_of(mesh), 0, mesh.triangles};
}

Mesh mesh_of(const Piece& piece)
{
    Mesh mesh;
    for (std::uint32_t v = 0; v < piece.vertices(); ++v)
        mesh.positions.push_back(piece.position(v));
    for (std::uint32_t h = 0; h < piece.halves(); h += 4)
        if (piece.alive(h))
            mesh.triangles.push_back({piece.from(h), piece.from(h + 1), piece.from(h + 2)});
    return mesh;
}

/// The edges of a piece by their ends.
std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges_of(const Piece& piece)
{
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges;
    for (std::uint32_t h = 0; h < piece.halves(); ++h)
        if ((h & 3U) != 3 && piece.alive(h))
            edges[std::minmax(piece.from(h), piece.to(h))] = h;
    return edges;
}

/// Vertices - edges + faces.
std::int64_t euler(const Mesh& mesh)
{
    const auto counts = count_surface(mesh);
    return std::int64_t(counts.vertices) - std::int64_t(counts.edges) + std::int64_t(counts.faces);
}

/// The mesh after the edge's first end took over its second, computed from the list of faces.
Mesh merged(const Mesh& mesh, std::uint32_t u, std::uint32_t v)
{
    Mesh result;
    result.positions = mesh.positions;
    for (Triangle t : mesh.triangles)
    {
        std::replace(t.begin(), t.end(), v, u);
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            result.triangles.push_back(t);
    }
    return result;
}

/// Whether the surface needs no repair: the faces around every vertex form one fan.
bool is_manifold(const Mesh& mesh)
{
    fresco::geometry::RepairReport report;
    fresco::geometry::repaired(mesh, report, fresco::Progress{});
    return report.complex_edges == 0 && report.vertices_added == 0;
}

}  // namespace

TEST_CASE("a collapse that is allowed keeps the surface a manifold with the same borders, components and holes")
{
    std::size_t allowed = 0;
    std::size_t refused = 0;
    for (const Mesh& mesh : {shapes::sphere(2, 3), shapes::torus(3), shapes::torus(4), shapes::box({0, 0, 0}, {1, 1, 1}),
                             shapes::grid(3, [](float x, float y) { return x * y; }), shapes::sphere(3, 3)})
    {
        const auto before = count_surface(mesh);
        for (const auto& [ends, h] : edges_of(piece_of(mesh)))
        {
            Piece piece = piece_of(mesh);
            const std::uint32_t u = piece.from(h);
            const std::uint32_t v = piece.to(h);
            const Vec3d middle =
                (fresco::vec_cast<double>(mesh.positions[u]) + fresco::vec_cast<double>(mesh.positions[v])) * 0.5 -
                piece.origin();
            if (!piece.allowed(h, middle))
            {
                ++refused;
                continue;
            }
            ++allowed;
            piece.collapse(h, middle);
            const Mesh plain = merged(mesh, u, v);
            auto ours = mesh_of(piece).triangles;
            auto theirs = plain.triangles;
            for (auto* faces : {&ours, &theirs})
            {
                for (Triangle& t : *faces)
                    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
                std::sort(faces->begin(), faces->end());
            }
            CHECK(ours == theirs);
            const auto after = count_surface(plain);
            CHECK(after.components == before.components);
            CHECK(euler(plain) == euler(mesh));
            CHECK((after.border_edges == 0) == (before.border_edges == 0));
            CHECK(is_manifold(plain));
        }
    }
    CHECK(allowed > 50);
    CHECK(refused > 50);
}

TEST_CASE("after many collapses every price equals that of a freshly made piece")
{
    for (Mesh mesh : {shapes::noisy_corner(16), shapes::sphere(14, 20)})
    {
        Mesh used;  // without the vertices that welding left over
        used.positions = mesh.positions;
        used.triangles = mesh.triangles;
        Piece piece = piece_of(used);
        EdgeQueue queue(piece);
        const std::size_t before = piece.faces();
        CHECK(queue.run(std::numeric_limits<float>::max(), before / 2) >= before / 2);
        CHECK(piece.faces() <= before - before / 2);
        const Mesh left = mesh_of(piece);
        CHECK(is_manifold(left));
        const Piece anew = piece_of(left);
        const auto fresh = edges_of(anew);
        for (const auto& [ends, h] : edges_of(piece))
        {
            REQUIRE(fresh.count(ends) == 1);
            const Placement ours = piece.placement(h);
            const Placement theirs = anew.placement(fresh.at(ends));
            if (std::isinf(ours.cost) || std::isinf(theirs.cost))
            {
                CHECK(ours.cost == theirs.cost);
                continue;
            }
            CHECK(ours.cost == Approx(theirs.cost).epsilon(1e-3).margin(1e-14));
            CHECK(length(ours.point + piece.origin() - theirs.point - anew.origin()) < 1e-3);
        }
    }
}

TEST_CASE(
    "errors are squared distances, to a face's plane times (twice its area)^1.25, to a border's line times its squared length")
{
    CHECK(plane_error({1, 1, 3}, {3, 1, 3}, {1, 3, 3})({0, 0, 5}) == Approx(4 * std::pow(4, 1.25)));
    CHECK(plane_error({1, 1, 3}, {2, 1, 3}, {3, 1, 3})({5, 5, 5}) == 0);
    CHECK(line_error({1, 5, 5}, {3, 5, 5})({-10, 8, 9}) == Approx(25 * 4));
}

TEST_CASE("an edge becomes the corner where the planes around it meet")
{
    Quadratic planes;
    for (const Quadratic& face : {plane_error({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), plane_error({0, 0, 0}, {0, 1, 0}, {0, 0, 1}),
                                  plane_error({0, 0, 0}, {0, 0, 1}, {1, 0, 0})})
        planes.add(face);
    const Placement corner = place(planes, nullptr, {-0.1, 0.1, 0}, {0.1, 0.1, 0.3});
    CHECK(length(corner.point) < 1e-5);
    CHECK(corner.cost < 1e-8);
    CHECK(corner.cost >= 0);
}

TEST_CASE("where no point near the edge serves the cost is infinite")
{
    CHECK(std::isinf(place({}, nullptr, {0, 0, 0}, {1, 0, 0}).cost));
    // Two planes that meet a hundred lengths away.
    Quadratic planes;
    planes.add(plane_error({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    planes.add(plane_error({0, 0, 0.1}, {1, 0, 0.101}, {0, 1, 0.1}));
    planes.add(plane_error({0, 0, 0}, {1, 0, 0}, {0, 0, 1}));
    CHECK(std::isinf(place(planes, nullptr, {0, 0, 0.05}, {0.1, 0, 0.05}).cost));
}
