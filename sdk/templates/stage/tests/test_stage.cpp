#include "catch.h"
#include "my_plugin.h"

#include <fresco/error.h>
#include <fresco/testing.h>

#include <memory>

namespace
{

fresco::Mesh triangle()
{
    fresco::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 2, 6}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

}  // namespace

TEST_CASE("a mesh is scaled about the middle of its box")
{
    const auto larger = my_plugin::scaled(triangle(), 2);
    CHECK(larger.positions[0] == fresco::Vec3f{-2, -1, -3});
    CHECK(larger.positions[1] == fresco::Vec3f{6, -1, -3});
    CHECK(larger.positions[2] == fresco::Vec3f{-2, 3, 9});
    CHECK(larger.triangles == triangle().triangles);
    CHECK(my_plugin::scaled({}, 2).positions.empty());
}

TEST_CASE("the stage runs, reports, and refuses a factor out of range")
{
    const fresco::testing::TemporaryFolder folder;
    fresco::testing::TestRun run;
    const auto scale = [&](double factor)
    {
        fresco::testing::run_stage(FRESCO_PLUGIN_FILE, "my.plugin", fresco::Value::Map{{"factor", factor}},
                                   {{"mesh", std::make_shared<fresco::Mesh>(triangle())}}, folder.path(), run);
    };
    scale(2);
    CHECK(run.reported.at("vertices").as_int() == 3);
    CHECK_THROWS_AS(scale(0), fresco::Error);
}
