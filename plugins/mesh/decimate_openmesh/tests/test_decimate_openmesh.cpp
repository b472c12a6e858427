#include "catch.h"
#include "decimate_openmesh.h"
#include "known_simplifications.h"

#include <fresco/geometry/topology.h>
#include <fresco/testing.h>

using fresco::Mesh;
using fresco::geometry::count_surface;

namespace
{

constexpr simplification::SimplifyingStage stage{FRESCO_PLUGIN_FILE, "mesh.decimate_openmesh"};

Mesh decimate(const Mesh& mesh, std::size_t faces)
{
    fresco::Progress progress;
    return decimated_openmesh(mesh, faces, progress);
}

}  // namespace

TEST_CASE("a flat square keeps its outline, its area and its colors")
{
    simplification::check_flat_square(decimate(simplification::flat_square(), 100), 1e-9);
}

TEST_CASE("a bump stays where it is: the surface moves less than its noise")
{
    const auto mesh = simplification::two_colored_grid(60, simplification::bump);
    simplification::check_bump(decimate(mesh, 600), mesh);
}

TEST_CASE("every component survives any target")
{
    const Mesh square = shapes::grid(4, [](float, float) { return 0.0F; });
    Mesh mesh;
    for (int copy = 0; copy < 5; ++copy)
    {
        shapes::append(mesh, square);
        for (std::size_t v = mesh.positions.size() - square.positions.size(); v < mesh.positions.size(); ++v)
            mesh.positions[v].z = static_cast<float>(copy);
    }
    shapes::append(mesh, shapes::box({0, 0, 9}, {1, 1, 1}));  // and a closed one
    const auto out = decimate(mesh, 4);
    CHECK(count_surface(out).components == 6);
    CHECK(out.triangles.size() >= 9);
    CHECK(out.triangles.size() <= 18);
    CHECK(count_surface(out).complex_edges == 0);
}

TEST_CASE("the stage reports, warns and can be stopped")
{
    simplification::check_stage(stage);
    fresco::testing::TestRun run;
    const auto smallest = stage(simplification::waves(), 4, run)->triangles.size();
    CHECK(smallest >= 3);  // a collapse takes at most two, so it stops at four or three
    CHECK(smallest <= 4);
}

TEST_CASE("known meshes: repaired with a count, no component lost, no hole or handle closed")
{
    simplification::check_known_meshes(stage);
}
