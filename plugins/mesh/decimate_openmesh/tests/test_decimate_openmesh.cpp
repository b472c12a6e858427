#include "catch.h"
#include "decimate_openmesh.h"
#include "known_simplifications.h"

#include <fresco/testing.h>

using fresco::Mesh;

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
