#include "catch.h"
#include "known_atlases.h"

using namespace fresco;

TEST_CASE("the stage: same ports and options, no overlap, less stretch than projection")
{
    const MadeAtlas sheet("atlas.lscm", shapes::bent_sheet(20), Value::Map{{"size_px", 256}});
    CHECK(check_atlas(*sheet.mesh, 256, 4).none());
    CHECK(sheet.reported("charts") == 1);
    CHECK(sheet.reported("mapped_charts") == 1);
    CHECK(sheet.reported("projected_charts") == 0);
    CHECK(sheet.reported("stretch_l2") == Approx(1).epsilon(1e-3));
}

TEST_CASE("a noisy corner: nearly all of it is mapped, nothing overlaps, and threads do not matter")
{
    check_noisy_corner_atlas("atlas.lscm");
}

TEST_CASE("known meshes: every face keeps its place, and the report lists their faults")
{
    check_known_atlases("atlas.lscm");
}
