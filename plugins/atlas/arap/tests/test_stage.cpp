#include "catch.h"
#include "known_atlases.h"

using namespace fresco;

TEST_CASE("bent sheets and those with holes unroll without any stretch")
{
    for (const auto& mesh : {shapes::bent_sheet(12), shapes::holed_sheet()})
    {
        const MadeAtlas sheet("atlas.arap", mesh, Value::Map{{"size_px", 256}});
        CHECK(sheet.reported("mapped_charts") == 1);
        CHECK(sheet.reported("stretch_linf") == Approx(1).epsilon(0.02));
    }
}

TEST_CASE("the stage: a ball at nearly one scale, without overlaps")
{
    const MadeAtlas atlas("atlas.arap", shapes::sphere(24, 48), Value::Map{{"size_px", 512}});
    CHECK(check_atlas(*atlas.mesh, 512, 4).none());
    CHECK(atlas.reported("mapped_area_share") > 0.9);
    CHECK(atlas.reported("density_variation") < 0.12);
    CHECK(atlas.reported("stretch_l2") < 1.05);
}

TEST_CASE("a noisy corner: nearly all of it is mapped, nothing overlaps, and threads do not matter")
{
    check_noisy_corner_atlas("atlas.arap");
}

TEST_CASE("known meshes: every face keeps its place, and the report lists their faults")
{
    check_known_atlases("atlas.arap");
}
