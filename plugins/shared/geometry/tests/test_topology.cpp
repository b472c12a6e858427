#include "catch.h"

#include <fresco/geometry/topology.h>

using namespace fresco::geometry;

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
