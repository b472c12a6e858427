#include "catch.h"
#include "flat_charts_check.h"
#include "known_atlases.h"
#include "lscm.h"

using fresco::Mesh;
using namespace fresco::geometry;

namespace
{

std::shared_ptr<Mesh> atlas_of(const Mesh& mesh, const fresco::Value& options, fresco::testing::TestRun& run)
{
    return made_atlas(FRESCO_PLUGIN_FILE, "atlas.lscm", mesh, options, run);
}

}  // namespace

TEST_CASE("a bent sheet unrolls without any stretch")
{
    const auto sheet = shapes::bent_sheet(12);
    const auto disk = whole_disk(sheet);
    const auto places = lscm_map(disk);
    REQUIRE(places);
    const auto& first = disk.triangles.front();
    const double scale =
        length((*places)[first[1]] - (*places)[first[0]]) / length(disk.points[first[1]] - disk.points[first[0]]);
    for (const auto& t : disk.triangles)
        for (std::size_t k = 0; k < 3; ++k)
        {
            const auto a = t[k];
            const auto b = t[(k + 1) % 3];
            CHECK(length((*places)[b] - (*places)[a]) == Approx(scale * length(disk.points[b] - disk.points[a])).epsilon(1e-3));
        }
}

TEST_CASE("the stage: same ports and options, no overlap, less stretch than projection")
{
    fresco::testing::TestRun run;
    const auto sheet = shapes::bent_sheet(20);
    const auto atlas = atlas_of(sheet, fresco::Value::Map{{"size_px", 256}}, run);
    CHECK(check_atlas(*atlas, 256, 4).none());
    CHECK(run.reported.at("charts").as_int() == 1);
    CHECK(run.reported.at("mapped_charts").as_int() == 1);
    CHECK(run.reported.at("projected_charts").as_int() == 0);
    CHECK(run.reported.at("stretch_l2").as_double() == Approx(1).epsilon(1e-3));

    fresco::testing::TestRun ball;
    const auto round = atlas_of(shapes::sphere(24, 48), fresco::Value::Map{{"size_px", 512}}, ball);
    CHECK(check_atlas(*round, 512, 4).none());
    CHECK(ball.reported.at("mapped_charts").as_int() >= 4);
}

TEST_CASE("a noisy corner: nearly all of it is mapped, nothing overlaps, and threads do not matter")
{
    check_noisy_corner_atlas(FRESCO_PLUGIN_FILE, "atlas.lscm");
}

TEST_CASE("known meshes: every face keeps its place, and the report lists their faults")
{
    check_known_atlases(FRESCO_PLUGIN_FILE, "atlas.lscm");
}
