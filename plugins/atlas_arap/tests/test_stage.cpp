#include "arap.h"
#include "catch.h"
#include "flat_charts_check.h"
#include "known_atlases.h"

using fresco::Mesh;
using fresco::Vec2d;
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

std::shared_ptr<Mesh> atlas_of(const Mesh& mesh, const fresco::Value& options, fresco::testing::TestRun& run)
{
    return made_atlas(FRESCO_PLUGIN_FILE, "atlas.arap", mesh, options, run);
}

}  // namespace

TEST_CASE("bent sheets and those with holes unroll without any stretch")
{
    for (auto sheet : {shapes::bent_sheet(12), shapes::holed_sheet()})
    {
        const auto disk = whole_disk(sheet);
        const auto places = arap_map(disk, seen_from_above(disk));
        REQUIRE(places);
        for (const auto& t : disk.triangles)
            for (std::size_t k = 0; k < 3; ++k)
            {
                const auto a = t[k];
                const auto b = t[(k + 1) % 3];
                CHECK(length((*places)[b] - (*places)[a]) == Approx(length(disk.points[b] - disk.points[a])).epsilon(0.01));
            }
    }
}

TEST_CASE("a square pulled askew goes back, wherever it lies")
{
    const auto disk = whole_disk(shapes::grid(6, [](float, float) { return 0.0F; }));
    auto from = seen_from_above(disk);
    for (auto& p : from)
        p = {3 * p.x + 0.8 * p.y + 100, 0.5 * p.y - 7};
    const auto places = arap_map(disk, from);
    REQUIRE(places);
    for (std::size_t v = 1; v < places->size(); ++v)
        CHECK(length((*places)[v] - (*places)[0]) == Approx(length(disk.points[v] - disk.points[0])).epsilon(0.02));
}

TEST_CASE("the stage: a ball at nearly one scale, without overlaps")
{
    fresco::testing::TestRun run;
    const auto atlas = atlas_of(shapes::sphere(24, 48), fresco::Value::Map{{"size_px", 512}}, run);
    CHECK(check_atlas(*atlas, 512, 4).none());
    CHECK(run.reported.at("mapped_area_share").as_double() > 0.9);
    CHECK(run.reported.at("density_variation").as_double() < 0.12);
    CHECK(run.reported.at("stretch_l2").as_double() < 1.05);
}

TEST_CASE("a noisy corner: nearly all of it is mapped, nothing overlaps, and threads do not matter")
{
    check_noisy_corner_atlas(FRESCO_PLUGIN_FILE, "atlas.arap");
}

TEST_CASE("known meshes: every face keeps its place, and the report lists their faults")
{
    check_known_atlases(FRESCO_PLUGIN_FILE, "atlas.arap");
}
