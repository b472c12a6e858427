#include "catch.h"
#include "shapes.h"

#include <fresco/geometry/topology.h>

using namespace fresco::geometry;

TEST_CASE("a box is counted right")
{
    const auto counts = count_surface(shapes::box({0, 0, 0}, {1, 2, 3}));
    CHECK(counts.faces == 12);
    CHECK(counts.vertices == 8);
    CHECK(counts.edges == 18);
    CHECK(counts.components == 1);
    CHECK(counts.border_edges == 0);
    CHECK(counts.complex_edges == 0);
    CHECK(counts.area_m2 == Approx(22));
}

TEST_CASE("an open square has its outline as border; two bodies are two components")
{
    auto mesh = shapes::grid(10, [](float, float) { return 0.0F; });
    CHECK(count_surface(mesh).border_length_m == Approx(4));
    CHECK(count_surface(mesh).border_edges == 40);
    shapes::append(mesh, shapes::box({3, 0, 0}, {1, 1, 1}));
    CHECK(count_surface(mesh).components == 2);
}

TEST_CASE("neighbors lie across the right edges and end where three faces meet")
{
    fresco::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, -1, 0}};
    mesh.triangles = {{0, 1, 2}, {2, 1, 3}};
    auto n = face_neighbors(mesh.triangles, 5);
    CHECK(n[0] == std::array<std::uint32_t, 3>{none, 1, none});
    CHECK(n[1] == std::array<std::uint32_t, 3>{0, none, none});
    mesh.triangles.push_back({1, 2, 4});
    n = face_neighbors(mesh.triangles, 5);
    CHECK(n[0] == std::array<std::uint32_t, 3>{none, none, none});
    CHECK(count_surface(mesh).complex_edges == 1);
    // Two faces that run the same way along their edge disagree about the outside.
    n = face_neighbors(std::vector<fresco::Triangle>{{0, 1, 2}, {1, 2, 3}}, 4);
    CHECK(n[0] == std::array<std::uint32_t, 3>{none, none, none});
}
