#include "catch.h"

#include <fresco/geometry/repair.h>

#include <fresco/geometry/topology.h>
#include <fresco/numerics/numerics.h>
#include <fresco/random.h>

#include <algorithm>
#include <cmath>

using fresco::Mesh;
using fresco::geometry::count_surface;
using fresco::geometry::repaired;
using fresco::geometry::RepairReport;

namespace
{

Mesh tetrahedron()
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
    return mesh;
}

/// Every edge has one or two faces, and the faces around a vertex are all reachable through edges there.
bool is_manifold(const Mesh& mesh)
{
    fresco::numerics::DisjointSets corners(3 * mesh.triangles.size());
    const auto neighbors = fresco::geometry::face_neighbors(mesh.triangles, mesh.positions.size());
    for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f)
        for (const auto g : neighbors[f])
            for (std::uint32_t c = 0; c < 9 && g != fresco::geometry::none; ++c)
                if (mesh.triangles[f][c / 3] == mesh.triangles[g][c % 3])
                    corners.join(3 * f + c / 3, 3 * g + c % 3);
    const auto counts = count_surface(mesh);
    return counts.complex_edges == 0 && corners.count() == counts.vertices;
}

}  // namespace

TEST_CASE("duplicate and degenerate faces and unused vertices go, with a count")
{
    auto mesh = tetrahedron();
    mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}, {0, 0, 0}, {0, 0, 0}};
    mesh.triangles.push_back({1, 0, 2});  // the first face, turned
    mesh.triangles.push_back({1, 1, 2});
    mesh.positions.push_back({2, 0, 0});
    mesh.triangles.push_back({0, 1, 4});  // on a line
    mesh.positions.push_back({9, 9, 9});
    RepairReport report;
    const auto out = repaired(mesh, report, fresco::Progress{});
    CHECK(report.duplicate_faces == 1);
    CHECK(report.degenerate_faces == 2);
    CHECK(report.vertices_unused == 2);
    CHECK(out.triangles == tetrahedron().triangles);
    CHECK(out.positions == tetrahedron().positions);
    CHECK(out.colors == std::vector(mesh.colors.begin(), mesh.colors.begin() + 4));
    CHECK(report.vertices_added + report.complex_edges == 0);
}

TEST_CASE("an edge without length is welded, so that no crack opens")
{
    // A square of two triangles with a needle between them: vertices 1 and 4 are one place.
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 0}};
    mesh.triangles = {{0, 1, 3}, {1, 4, 3}, {4, 2, 3}};
    RepairReport report;
    const auto out = repaired(mesh, report, fresco::Progress{});
    CHECK(report.vertices_welded == 1);
    CHECK(report.degenerate_faces == 1);
    CHECK(report.vertices_unused == 0);
    CHECK(out.triangles.size() == 2);
    CHECK(count_surface(out).border_edges == 4);
}

TEST_CASE("a hundred thousand faces on one edge come apart into the planes they are of")
{
    // The planes through the z axis, each of two triangles; all pairs of the edge's faces would fill 40 GB.
    constexpr std::uint32_t planes = 50'000;
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}};
    for (std::uint32_t k = 0; k < planes; ++k)
    {
        const double angle = 3.14159265358979 * k / planes;
        const fresco::Vec3f outward{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0};
        mesh.positions.push_back(outward);
        mesh.positions.push_back(-outward);
        mesh.triangles.push_back({0, 1, 2 + 2 * k});
        mesh.triangles.push_back({1, 0, 3 + 2 * k});
    }
    RepairReport report;
    const auto out = repaired(mesh, report, fresco::Progress{});
    CHECK(report.complex_edges == 1);
    CHECK(report.vertices_added == 2 * (planes - 1));
    REQUIRE(out.triangles.size() == 2 * planes);
    for (std::uint32_t k = 0; k < planes; ++k)
        if (out.triangles[2 * k][0] != out.triangles[2 * k + 1][1] || out.triangles[2 * k][1] != out.triangles[2 * k + 1][0])
            FAIL_CHECK("plane " << k << " was parted");
}

TEST_CASE("any soup of faces comes back manifold, with every face that has an area and is no copy")
{
    // Few vertices, many faces: nearly every edge is complex, and many faces must be detached.
    fresco::Random numbers(1);
    const auto random = [&](int below) { return static_cast<std::uint32_t>(numbers.below(below)); };
    std::size_t detached = 0;
    for (int round = 0; round < 300; ++round)
    {
        Mesh mesh;
        for (int v = 0; v < 7; ++v)
            mesh.positions.push_back(
                {static_cast<float>(random(100)), static_cast<float>(random(100)), static_cast<float>(random(100))});
        for (int f = 0; f < 12; ++f)
            mesh.triangles.push_back({random(7), random(7), random(7)});
        RepairReport report;
        const Mesh out = repaired(mesh, report, fresco::Progress{});
        CHECK(is_manifold(out));
        CHECK(out.triangles.size() + report.degenerate_faces + report.duplicate_faces == mesh.triangles.size());
        detached += report.faces_detached;
    }
    CHECK(detached > 0);
}
