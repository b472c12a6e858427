#include "catch.h"
#include <fresco/testing_scenes.h>

#include <fresco/testing.h>

using namespace fresco;

namespace
{
std::shared_ptr<const TexturedMesh> baked(const Value& options, const Texture& texture, const Mesh& mesh, testing::TestRun& run)
{
    testing::TemporaryFolder folder;
    testing::run_stage(FRESCO_PLUGIN_FILE, "texture.bake", options,
                       {{"texture", std::make_shared<Texture>(texture)}, {"mesh", std::make_shared<Mesh>(mesh)}}, folder.path(),
                       run);
    return TexturedMesh::load({folder.path() / "textured_mesh", folder.path()});
}
}  // namespace

TEST_CASE("the stage gives the mesh its picture and reports the shares")
{
    Texture texture = testing::blank_texture(80, 0.0F);
    testing::see(texture, {0.0F, 0.0F}, {0.5F, 0.5F}, {0.2F, 0.4F, 0.6F});
    testing::TestRun run;
    const auto result = baked(Value::Map{}, texture, testing::two_chart_wall(), run);
    CHECK(result->mesh.texcoords == testing::two_chart_wall().texcoords);
    CHECK(result->mesh.triangles == testing::two_chart_wall().triangles);
    CHECK(result->image.pixels.width == 80);
    CHECK(result->image.pixels.channels == 3);
    CHECK(result->image.pixels.at(60, 60, 1) == 102);
    CHECK(run.reported.at("seen_share").as_double() == Approx(0.5));
    CHECK(run.reported.at("filled_share").as_double() == Approx(0.5));
    CHECK(run.reported.at("chart_share").as_double() == Approx(2 * 24 * 24 / 6400.0));
}

TEST_CASE("the stage refuses what it cannot use")
{
    testing::TestRun run;
    const Texture texture = testing::blank_texture(16, 0.5F);
    Mesh bare = testing::two_chart_wall();
    bare.texcoords.clear();
    CHECK_THROWS_WITH(baked(Value::Map{}, texture, bare, run), Catch::Contains("no texcoords"));
    CHECK_THROWS_WITH(baked(Value::Map{{"unseen_color", Value::List{1, 2}}}, texture, testing::two_chart_wall(), run),
                      Catch::Contains("unseen_color\" has 2 numbers"));
    CHECK_THROWS_WITH(baked(Value::Map{{"unseen", "blur"}}, texture, testing::two_chart_wall(), run), Catch::Contains("unseen"));
    run.cancel_after(2);
    CHECK_THROWS_AS(baked(Value::Map{{"unseen", "keep"}}, texture, testing::two_chart_wall(), run), Canceled);
}
