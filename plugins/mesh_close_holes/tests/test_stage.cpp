#include "catch.h"

#include <fresco/mesh.h>
#include <fresco/testing.h>
#include <fresco/testing_scenes.h>

using namespace fresco;

TEST_CASE("the stage reports what it closed, and refuses an invalid mesh")
{
    // A box of 1 m without its lid, whose opening is 1.41 m wide.
    auto open = std::make_shared<Mesh>(testing::box());
    open->triangles.resize(10);
    const testing::TemporaryFolder folder;
    const auto run_with = [&](double width_cm, testing::TestRun& run)
    {
        testing::run_stage(FRESCO_PLUGIN_FILE, "mesh.close_holes", Value::Map{{"max_width_cm", width_cm}}, {{"mesh", open}},
                           folder.path(), run);
        return Mesh::load({folder.path() / "closed", folder.path()});
    };
    testing::TestRun closing;
    CHECK(run_with(150, closing)->triangles.size() > 11);
    CHECK(closing.reported.at("holes_closed").as_int() == 1);
    CHECK(closing.reported.at("added_area_m2").as_double() == Approx(1).epsilon(0.3));
    testing::TestRun leaving;
    CHECK(run_with(100, leaving)->triangles.size() == 10);
    CHECK(leaving.reported.at("holes_too_large").as_int() == 1);
    open->triangles.front()[0] = 99;
    CHECK_THROWS_WITH(run_with(100, leaving), Catch::Contains("port 'mesh'"));
}
