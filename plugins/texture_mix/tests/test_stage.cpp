#include "catch.h"
#include "mixture.h"
#include <fresco/testing_scenes.h>

#include <fresco/testing.h>

using namespace fresco;

namespace
{
constexpr int side = 80;

/// The wall in one color, seen as a whole.
Texture wall(Vec3f rgb)
{
    Texture texture = testing::blank_texture(side, 0.0F);
    testing::see(texture, {0, 0}, {1, 1}, rgb);
    return texture;
}

std::shared_ptr<const Texture> mixed(const Value& options, const Texture& photo, const Texture& painted, testing::TestRun& run,
                                     const Mesh& mesh = testing::two_chart_wall())
{
    testing::TemporaryFolder folder;
    testing::run_stage(FRESCO_PLUGIN_FILE, "texture.mix", options,
                       {{"photo", std::make_shared<Texture>(photo)},
                        {"painted", std::make_shared<Texture>(painted)},
                        {"mesh", std::make_shared<Mesh>(mesh)}},
                       folder.path(), run);
    return Texture::load({folder.path() / "texture", folder.path()});
}

/// The color in the middle of the left chart.
Vec3f color(const Texture& texture)
{
    const RasterF& layer = texture.layers.front();
    return {layer.at(side / 4, 3 * side / 4, 0), layer.at(side / 4, 3 * side / 4, 1), layer.at(side / 4, 3 * side / 4, 2)};
}
}  // namespace

TEST_CASE("the stage mixes and reports how far the mixture is from both", "[texture.mix]")
{
    double last_photo = -1;
    double last_painted = 1000;
    for (int step = 0; step <= 10; ++step)
    {
        testing::TestRun run;
        const double share = step / 10.0;
        const auto result =
            mixed(Value::Map{{"color", share}, {"strokes", share}}, wall({0.2F, 0.4F, 0.6F}), wall({0.6F, 0.2F, 0.4F}), run);
        CHECK(result->values == "display");
        CHECK(result->atlas == atlas_id(testing::two_chart_wall()));
        CHECK(length(color(*result) - Vec3f{0.2F, 0.4F, 0.6F} - Vec3f{0.4F, -0.2F, -0.2F} * static_cast<float>(share)) < 1e-5F);
        const double photo = run.reported.at("from_photo").as_double();
        const double painted = run.reported.at("from_painted").as_double();
        CHECK(photo > last_photo);
        CHECK(painted < last_painted);
        last_photo = photo;
        last_painted = painted;
    }
    CHECK(last_painted == 0);
}

TEST_CASE("the page can mix as the stage does", "[texture.mix]")
{
    // Two colors of the wall's halves and fine stripes: both bands differ.
    Texture photo = wall({0.2F, 0.4F, 0.6F});
    testing::see(photo, {0.5F, 0}, {1, 0.5F}, {0.5F, 0.3F, 0.2F});
    Texture painted = wall({0.6F, 0.3F, 0.4F});
    for (int x = 0; x < side; x += 4)
        for (int y = 0; y < side; ++y)
            painted.layers.front().at(x, y, 1) += 0.2F;
    const testing::TemporaryFolder folder;
    const auto run_mix = [&](double color, double strokes)
    {
        testing::TestRun run;
        testing::run_stage(FRESCO_PLUGIN_FILE, "texture.mix", Value::Map{{"color", color}, {"strokes", strokes}},
                           {{"photo", std::make_shared<Texture>(photo)},
                            {"painted", std::make_shared<Texture>(painted)},
                            {"mesh", std::make_shared<Mesh>(testing::two_chart_wall())}},
                           folder.path(), run);
        return Texture::load({folder.path() / "texture", folder.path()});
    };
    const auto texture = run_mix(0.3, 0.8);
    const auto small = Mixture::load({folder.path() / "sliders", folder.path()});
    CHECK(small->atlas == atlas_id(testing::two_chart_wall()));
    CHECK(small->color == 0.3);
    CHECK(small->strokes == 0.8);
    REQUIRE(small->painted.width == side);
    double farthest = 0;
    for (std::size_t texel = 0; texel < texture->seen.values.size(); ++texel)
        if (texture->seen.values[texel] != 0)
            for (std::size_t i = 3 * texel; i < 3 * texel + 3; ++i)
            {
                const double p = small->photo.values[i];
                const double c = small->colors.values[i];
                const double s = small->painted.values[i];
                farthest = std::max(farthest, std::abs(p + 0.3 * (c - p) + 0.8 * (s - c) - 255.0 * texture->layers[0].values[i]));
            }
    CHECK(farthest < 1.5);
}

TEST_CASE("what one of the textures lacks is continued from its surroundings before mixing", "[texture.mix]")
{
    Texture photo = testing::blank_texture(side, 0.0F);
    testing::see(photo, {0, 0}, {0.5F, 0.5F}, {0.2F, 0.2F, 0.2F});  // only the left chart
    testing::TestRun run;
    const auto result = mixed(Value::Map{{"color", 0.5}, {"strokes", 0.5}}, photo, wall({0.6F, 0.6F, 0.6F}), run);
    CHECK(result->layers.front().at(3 * side / 4, 3 * side / 4, 0) == Approx(0.4));
    CHECK(result->seen.at(3 * side / 4, 3 * side / 4) == 1);
    CHECK(result->seen.at(side / 2, side / 4) == 0);
}

TEST_CASE("the stage refuses textures that do not belong together", "[texture.mix]")
{
    testing::TestRun run;
    const Texture photo = wall({});
    CHECK_THROWS_WITH(mixed(Value::Map{}, photo, testing::blank_texture(side / 2, 0), run),
                      Catch::Contains("'photo' has 80 texels a side, the one on port 'painted' 40"));
    Texture other = photo;
    other.atlas = "00000000000000000000000000000000";
    CHECK_THROWS_WITH(mixed(Value::Map{}, photo, other, run), Catch::Contains("the texture on port 'painted'"));
    Mesh bare = testing::two_chart_wall();
    bare.texcoords.clear();
    CHECK_THROWS_WITH(mixed(Value::Map{}, photo, photo, run, bare), Catch::Contains("has no texcoords"));
    CHECK_THROWS_WITH(mixed(Value::Map{{"color", 1.5}}, photo, photo, run), Catch::Contains("color"));
    CHECK_THROWS_WITH(mixed(Value::Map{}, testing::blank_texture(side, 0), photo, run), Catch::Contains("seen"));
}
