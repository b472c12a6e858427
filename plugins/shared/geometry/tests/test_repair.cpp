#include "catch.h"

#include <fresco/geometry/repair.h>

#include <fresco/geometry/topology.h>
#include <fresco/random.h>

#include <algorithm>
#include <cmath>

using fresco::Mesh;
using fresco::geometry::count_surface;
using fresco::geometry::repaired;
using fresco::geometry::RepairReport;

namespace
{

Mesh tetrahedron(fresco::Vec3f at, Mesh mesh = {})
{
    const auto n = static_cast<std::uint32_t>(mesh.positions.size());
    for (const fresco::Vec3f p : {fresco::Vec3f{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
        mesh.positions.push_back(at + p);
    for (const fresco::Triangle t : {fresco::Triangle{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}})
        mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    return mesh;
}

/// The slow obvious check: every edge has one or two faces, and the faces around a vertex are all reachable through edges there.
bool is_manifold(const Mesh& mesh)
{
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v)
    {
        std::vector<fresco::Triangle> fan;
        for (const auto& t : mesh.triangles)
            if (std::count(t.begin(), t.end(), v) > 0)
                fan.push_back(t);
        for (std::uint32_t w = 0; w < mesh.positions.size(); ++w)
        {
            const auto uses = [&](std::uint32_t a, std::uint32_t b)
            {
                return std::count_if(fan.begin(), fan.end(),
                                     [&](const auto& t) {
                                         return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
                                     });
            };
            if (w != v && (uses(v, w) > 1 || uses(w, v) > 1))
                return false;
        }
        std::vector<bool> reached(fan.size(), false);
        if (!fan.empty())
            reached[0] = true;
        for (std::size_t round = 0; round < fan.size(); ++round)
            for (std::size_t a = 0; a < fan.size(); ++a)
                for (std::size_t b = 0; b < fan.size(); ++b)
                {
                    const auto shared = std::count_if(fan[a].begin(), fan[a].end(),
                                                      [&](auto w) { return std::count(fan[b].begin(), fan[b].end(), w) > 0; });
                    if (reached[a] && shared >= 2)  // 3: a face and its back
                        reached[b] = true;
                }
        if (std::count(reached.begin(), reached.end(), false) > 0)
            return false;
    }
    return true;
}

Mesh repair(const Mesh& mesh, RepairReport& report)
{
    report = {};
    return repaired(mesh, report, fresco::Progress{});
}

}  // namespace

TEST_CASE("a clean mesh comes back as it was")
{
    auto mesh = tetrahedron({});
    mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
    RepairReport report;
    const auto out = repair(mesh, report);
    CHECK(out.positions == mesh.positions);
    CHECK(out.triangles == mesh.triangles);
    CHECK(out.colors == mesh.colors);
    CHECK(report.vertices_added + report.complex_edges + report.duplicate_faces + report.degenerate_faces == 0);
    CHECK(count_surface(out).border_edges == 0);
    CHECK(count_surface(out).components == 1);
}

TEST_CASE("duplicate and degenerate faces and unused vertices go, with a count")
{
    auto mesh = tetrahedron({});
    mesh.triangles.push_back({1, 0, 2});  // the first face, turned
    mesh.triangles.push_back({1, 1, 2});
    mesh.positions.push_back({2, 0, 0});
    mesh.triangles.push_back({0, 1, 4});  // on a line
    mesh.positions.push_back({9, 9, 9});
    RepairReport report;
    const auto out = repair(mesh, report);
    CHECK(report.duplicate_faces == 1);
    CHECK(report.degenerate_faces == 2);
    CHECK(report.vertices_unused == 2);
    CHECK(out.triangles == tetrahedron({}).triangles);
    CHECK(out.positions.size() == 4);
}

TEST_CASE("an edge without length is welded, so that no crack opens")
{
    // A square of two triangles with a needle between them: vertices 1 and 4 are one place.
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 0}};
    mesh.triangles = {{0, 1, 3}, {1, 4, 3}, {4, 2, 3}};
    RepairReport report;
    const auto out = repair(mesh, report);
    CHECK(report.vertices_welded == 1);
    CHECK(report.degenerate_faces == 1);
    CHECK(report.vertices_unused == 0);
    CHECK(out.triangles.size() == 2);
    CHECK(count_surface(out).border_edges == 4);
}

TEST_CASE("a fin on a plane is separated and keeps its faces, and the plane stays whole")
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
    mesh.triangles = {{0, 1, 4}, {0, 1, 2}, {1, 0, 3}};
    RepairReport report;
    const auto out = repair(mesh, report);
    CHECK(out.triangles.size() == 3);
    CHECK(is_manifold(out));
    CHECK(report.vertices_added == 2);
    CHECK(out.triangles[1][0] == out.triangles[2][1]);
    CHECK(out.triangles[0][0] != out.triangles[1][0]);
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
        const auto x = static_cast<float>(std::cos(angle));
        const auto y = static_cast<float>(std::sin(angle));
        mesh.positions.push_back({x, y, 0});
        mesh.positions.push_back({-x, -y, 0});
        mesh.triangles.push_back({0, 1, 2 + 2 * k});
        mesh.triangles.push_back({1, 0, 3 + 2 * k});
    }
    RepairReport report;
    const auto out = repair(mesh, report);
    CHECK(report.complex_edges == 1);
    CHECK(report.faces_detached == 0);
    CHECK(report.vertices_added == 2 * (planes - 1));
    REQUIRE(out.triangles.size() == 2 * planes);
    std::size_t whole = 0;
    for (std::uint32_t k = 0; k < planes; ++k)
        whole += out.triangles[2 * k][0] == out.triangles[2 * k + 1][1] && out.triangles[2 * k][1] == out.triangles[2 * k + 1][0];
    CHECK(whole == planes);
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
