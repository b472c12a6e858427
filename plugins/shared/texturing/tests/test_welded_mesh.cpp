#include "catch.h"

#include <fresco/testing_scenes.h>
#include <fresco/texturing/exports.h>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
/// Two squares of one wall; `cut`: they lie apart in the atlas.
Mesh wall(bool cut)
{
    Mesh mesh = testing::two_chart_wall();
    if (!cut)
        testing::set_texcoords(mesh, [](Vec3f p) { return Vec2f{p.x / 4, p.y / 4}; });
    return mesh;
}
}  // namespace

TEST_CASE("a mesh that was split along a seam is welded by position")
{
    Mesh mesh = wall(false);
    mesh.positions.push_back(mesh.positions[1]);
    mesh.positions.push_back(mesh.positions[4]);
    mesh.triangles[2] = {6, 2, 5};
    mesh.triangles[3] = {6, 5, 7};
    CHECK(weld(mesh).positions.size() == 6);
}

TEST_CASE("normals are smooth across seams, of unit length, and defined where faces have no area")
{
    Mesh mesh = wall(true);
    mesh.positions[2] = {1, 0, 1};  // bend the right square by 90 degrees
    mesh.positions[5] = {1, 1, 1};
    mesh.positions.push_back({9, 9, 9});
    mesh.triangles.push_back({6, 6, 6});
    for (int i = 0; i < 3; ++i)
        mesh.texcoords.push_back({0.9F, 0.9F});
    const WeldedMesh welded = weld(mesh);
    REQUIRE(welded.indices.size() == 15);
    for (std::size_t v = 0; v < welded.positions.size(); ++v)
    {
        CHECK(length(welded.normals[v]) == Approx(1));
        if (welded.positions[v] == Vec3f{0, 0, 0})
            CHECK(welded.normals[v] == Vec3f{0, 0, 1});
        if (welded.positions[v] == Vec3f{1, 0, 0})
            CHECK(welded.normals[v].z < 0.95F);  // both squares, on both sides of the seam
    }
}
