#include "catch.h"
#include "rooms.h"

#include <fresco/regions/regions.h>
#include <fresco/testing.h>

#include <algorithm>

using namespace fresco;

namespace
{

std::shared_ptr<Regions> divided(const Mesh& mesh, const Value& options, testing::TestRun& run)
{
    testing::TemporaryFolder folder;
    testing::run_stage(FRESCO_PLUGIN_FILE, "regions.planes", options, {{"mesh", std::make_shared<Mesh>(mesh)}}, folder.path(),
                       run);
    return Regions::load({folder.path() / "regions", folder.path()});
}

}  // namespace

TEST_CASE("regions.planes finds the parts of a room that stands upright or lies", "[regions.planes]")
{
    KnownRoom room;
    room.noise_m = 0.003;
    room.shell({4, 3, 2.4F});
    room.table(1, 1);
    testing::TestRun run;
    const auto upright = divided(room.mesh, Value::Map{}, run);
    CHECK(upright->names == std::vector<std::string>{"floor", "ceiling", "walls", "furniture"});
    CHECK(upright->atlas == atlas_id(room.mesh));
    CHECK(run.reported.at("floors").as_int() == 1);
    CHECK(run.reported.at("ceiling_m").as_double() == Approx(2.4).margin(0.01));
    CHECK(run.reported.at("area_share").at("floor").as_double() == Approx(0.2).margin(0.04));

    // Up is y.
    Mesh lying = room.mesh;
    for (Vec3f& p : lying.positions)
        p = {p.x, p.z, -p.y};
    for (const char* up : {"auto", "y"})
        CHECK(divided(lying, Value::Map{{"up", up}}, run)->label_of_face == upright->label_of_face);
}

TEST_CASE("regions.planes says where there is no floor, and refuses what is no mesh", "[regions.planes]")
{
    KnownRoom wall;
    wall.sheet(RoomPart::walls, {}, {4, 0, 0}, {0, 0, 2.5F});
    testing::TestRun run;
    const auto regions = divided(wall.mesh, Value::Map{{"up", "z"}}, run);
    CHECK(run.reported.at("floors").as_int() == 0);
    const auto told = [&](const char* text)
    { return std::ranges::any_of(run.messages, [&](const auto& line) { return line.find(text) != line.npos; }); };
    CHECK(told("warning: no floor was found"));
    // A wall by itself could be a floor: that contradicts nobody.
    CHECK_FALSE(told("warning: up: z, but"));
    CHECK(run.reported.at("area_share").at("walls").as_double() > 0.95);
    CHECK_THROWS_WITH(divided(Mesh{}, Value::Map{}, run), Catch::Contains("the mesh on port 'mesh'"));
}
