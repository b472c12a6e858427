#include "catch.h"
#include "plugin_under_test.h"
#include "rooms.h"

#include <fresco/regions/regions.h>

#include <algorithm>

using namespace fresco;

namespace
{

std::shared_ptr<Regions> divided(const Mesh& mesh, const Value& options, testing::TestRun& run)
{
    return testing::output_of<Regions>("regions.planes", "regions", options, {{"mesh", std::make_shared<Mesh>(mesh)}}, run);
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "regions.planes finds the parts of a room that stands upright or lies", "[regions.planes]")
{
    KnownRoom room;
    room.noise_m = 0.003;
    room.shell({4, 3, 2.4F});
    room.table(1, 1);
    const auto upright = divided(room.mesh, Value::Map{}, run);
    // Noise parts the top of the table from its underside.
    CHECK(upright->names ==
          std::vector<std::string>{"floor", "ceiling", "walls", "furniture", "furniture/part_1", "furniture/part_2"});
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

TEST_CASE_METHOD(testing::StageTest, "regions.planes says where there is no floor, and refuses what is no mesh",
                 "[regions.planes]")
{
    KnownRoom wall;
    wall.sheet(RoomPart::walls, {}, {4, 0, 0}, {0, 0, 2.5F});
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
