#include "catch.h"
#include "flat_charts_check.h"
#include "known_atlases.h"
#include "lscm.h"

using namespace fresco;
using namespace fresco::geometry;

TEST_CASE("a bent sheet unrolls without any stretch")
{
    const auto sheet = shapes::bent_sheet(12);
    const auto disk = whole_disk(sheet);
    const auto places = lscm_map(disk);
    REQUIRE(places);
    const auto& first = disk.triangles.front();
    const double scale =
        length((*places)[first[1]] - (*places)[first[0]]) / length(disk.points[first[1]] - disk.points[first[0]]);
    check_lengths(disk, *places, scale, 1e-3);
}

TEST_CASE("the stage: same ports and options, no overlap, less stretch than projection")
{
    const MadeAtlas sheet("atlas.lscm", shapes::bent_sheet(20), Value::Map{{"size_px", 256}});
    CHECK(check_atlas(*sheet.mesh, 256, 4).none());
    CHECK(sheet.reported("charts") == 1);
    CHECK(sheet.reported("mapped_charts") == 1);
    CHECK(sheet.reported("projected_charts") == 0);
    CHECK(sheet.reported("stretch_l2") == Approx(1).epsilon(1e-3));

    const MadeAtlas ball("atlas.lscm", shapes::sphere(24, 48), Value::Map{{"size_px", 512}});
    CHECK(check_atlas(*ball.mesh, 512, 4).none());
    CHECK(ball.reported("mapped_charts") >= 4);
}

TEST_CASE("a noisy corner: nearly all of it is mapped, nothing overlaps, and threads do not matter")
{
    check_noisy_corner_atlas("atlas.lscm");
}

TEST_CASE("known meshes: every face keeps its place, and the report lists their faults")
{
    check_known_atlases("atlas.lscm");
}
