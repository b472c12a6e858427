#include "catch.h"

#include <fresco/testing_scenes.h>
#include <fresco/texturing/exports.h>

#include <array>
#include <cmath>

using namespace fresco;
using namespace fresco::texturing;

TEST_CASE("a mesh that was split along a seam is welded by position")
{
    Mesh mesh = testing::two_chart_wall();
    testing::set_texcoords(mesh, [](Vec3f p) { return Vec2f{p.x / 4, p.y / 4}; });
    mesh.positions.push_back(mesh.positions[1]);
    mesh.positions.push_back(mesh.positions[4]);
    mesh.triangles[2] = {6, 2, 5};
    mesh.triangles[3] = {6, 5, 7};
    CHECK(weld(mesh).positions.size() == 6);
}

TEST_CASE("normals are smooth across seams, of unit length, and defined where faces have no area")
{
    Mesh mesh = testing::two_chart_wall();
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

TEST_CASE("tangents run along u, square to the normal, and say which charts are mirrored")
{
    Mesh mesh = testing::two_chart_wall();
    // The left square's u along -y and v along x, the right one seen in a mirror.
    for (std::size_t corner = 0; corner < mesh.texcoords.size(); ++corner)
    {
        const Vec3f p = mesh.positions[mesh.triangles[corner / 3][corner % 3]];
        mesh.texcoords[corner] = corner < 6 ? Vec2f{0.4F - 0.3F * p.y, 0.1F + 0.3F * p.x} : Vec2f{1.2F - 0.3F * p.x, 0.3F * p.y};
    }
    WeldedMesh welded = weld(mesh);
    add_tangents(welded);
    REQUIRE(welded.positions.size() == 8);
    for (std::size_t corner = 0; corner < 12; ++corner)
        CHECK(welded.tangents[welded.indices[corner]] ==
              (corner < 6 ? std::array{0.0F, -1.0F, 0.0F, 1.0F} : std::array{-1.0F, 0.0F, 0.0F, -1.0F}));
    // A mirrored chart that shares texcoords with one that is not mirrored gets vertices of its own.
    for (std::size_t corner = 6; corner < 12; ++corner)
        mesh.texcoords[corner].x = 0.3F * std::abs(mesh.positions[mesh.triangles[corner / 3][corner % 3]].x - 1);
    for (std::size_t corner = 0; corner < 6; ++corner)
        mesh.texcoords[corner] = {0.3F * (1 - mesh.positions[mesh.triangles[corner / 3][corner % 3]].x),
                                  0.3F * mesh.positions[mesh.triangles[corner / 3][corner % 3]].y};
    welded = weld(mesh);
    REQUIRE(welded.positions.size() == 6);
    add_tangents(welded);
    CHECK(welded.positions.size() == 8);
    for (std::size_t corner = 0; corner < 12; ++corner)
        CHECK(welded.tangents[welded.indices[corner]][3] == (corner < 6 ? -1 : 1));
}
