#include "catch.h"
#include "decimate.h"
#include "known_simplifications.h"

#include <fresco/geometry/repair.h>
#include <fresco/geometry/topology.h>
#include <fresco/testing.h>

using fresco::Mesh;
using fresco::geometry::count_surface;

namespace
{

constexpr simplification::SimplifyingStage stage{FRESCO_PLUGIN_FILE, "mesh.decimate"};

Mesh decimate(const Mesh& mesh, std::size_t faces, std::size_t piece_faces = 32768, int threads = 2)
{
    fresco::testing::TestRun progress(threads);
    fresco::geometry::RepairReport report;
    return decimated(fresco::geometry::repaired(mesh, report, progress), {.max_faces = faces, .piece_faces = piece_faces},
                     progress);
}

}  // namespace

TEST_CASE("a flat square keeps its outline, its area and its colors")
{
    for (const std::size_t piece_faces : {64, 100000})
        simplification::check_flat_square(decimate(simplification::flat_square(), 100, piece_faces), 1e-5);
}

TEST_CASE("a bump stays where it is, cut into pieces as well as whole")
{
    const auto mesh = shapes::grid(80, simplification::bump);
    for (const std::size_t piece_faces : {500, 32768})
        simplification::check_bump(decimate(mesh, 600, piece_faces), mesh);
}

TEST_CASE("the result does not depend on threads")
{
    const auto mesh = shapes::noisy_corner(40);
    const auto one = decimate(mesh, 3000, 700, 1);
    for (const int threads : {2, 5})
    {
        const auto many = decimate(mesh, 3000, 700, threads);
        CHECK(one.positions == many.positions);
        CHECK(one.triangles == many.triangles);
    }
}

TEST_CASE("what a surface is stays: components, holes, borders")
{
    Mesh mesh = shapes::grid(8, [](float, float) { return 0.0F; });
    shapes::append(mesh, shapes::box({5, 0, 0}, {1, 1, 1}));
    shapes::append(mesh, shapes::sphere(10, 12));
    for (int i = 0; i < 2000; ++i)  // crumbs
    {
        Mesh crumb;
        const auto x = static_cast<float>(i);
        crumb.positions = {{x, 9, 0}, {x + 0.5F, 9, 0}, {x, 9.5F, 0}};
        crumb.triangles = {{0, 1, 2}};
        shapes::append(mesh, crumb);
    }
    const auto before = count_surface(mesh);
    for (const std::size_t piece_faces : {64, 100000})
    {
        const auto out = decimate(mesh, 4, piece_faces);
        const auto after = count_surface(out);
        CHECK(after.components == before.components);
        CHECK(after.complex_edges == 0);
        CHECK(after.faces >= 2000 + 4 + 4 + 1);
        CHECK(after.faces <= 2000 + 30);
    }
}

TEST_CASE("the stage gives the core's mesh, reports, warns and can be stopped")
{
    simplification::check_stage(stage);
    fresco::testing::TestRun run;
    CHECK(stage(simplification::waves(), 5000, run)->triangles == decimate(simplification::waves(), 5000).triangles);
}

TEST_CASE("known meshes: repaired with a count, no component lost, no hole or handle closed")
{
    simplification::check_known_meshes(stage);
}
