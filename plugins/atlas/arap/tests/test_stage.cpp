#include "arap.h"
#include "catch.h"
#include "flat_charts_check.h"
#include "known_atlases.h"

using namespace fresco;
using namespace fresco::geometry;

namespace
{

std::vector<Vec2d> seen_from_above(const Disk& disk)
{
    std::vector<Vec2d> places;
    for (const auto& p : disk.points)
        places.push_back({p.x, p.y});
    return places;
}

}  // namespace

TEST_CASE("bent sheets and those with holes unroll without any stretch")
{
    for (auto sheet : {shapes::bent_sheet(12), shapes::holed_sheet()})
    {
        const auto disk = whole_disk(sheet);
        const auto places = arap_map(disk, seen_from_above(disk));
        REQUIRE(places);
        check_lengths(disk, *places, 1, 0.01);
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
