#include "bake.h"
#include "catch.h"
#include "plugin_under_test.h"

#include <fresco/error.h>
#include <fresco/testing_scenes.h>

#include <cmath>

using namespace fresco;

namespace
{
constexpr int size = 80;

Raster8 baked(const Texture& texture, const Mesh& mesh, Unseen unseen = Unseen::fill)
{
    testing::TestRun run;
    BakeCounts counts;
    return bake(texture, mesh, unseen, counts, run);
}

/// The red value at a uv, of the texel that holds it.
int red(const Raster8& image, float u, float v)
{
    return image.at(static_cast<int>(u * size), static_cast<int>((1 - v) * size));
}

/// A texture of which nothing was seen yet.
struct BakeTest
{
    Texture texture = testing::blank_texture(size, 0.0F);
};
}  // namespace

TEST_CASE_METHOD(BakeTest, "the hidden half of a wall takes the seen half's color and no texel keeps its initial value")
{
    testing::see(texture, {0.1F, 0.1F}, {0.25F, 0.4F}, {0.8F, 0.4F, 0.2F});  // the left half of the left chart
    const Raster8 image = baked(texture, testing::two_chart_wall());
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            INFO(x << ", " << y);
            CHECK(image.at(x, y, 0) == 204);
            CHECK(image.at(x, y, 1) == 102);
            CHECK(image.at(x, y, 2) == 51);
        }
}

TEST_CASE_METHOD(BakeTest, "colors cross a seam at the right place and not the gutter")
{
    // The left chart is seen, dark below and bright above; the right one is hidden and turned by 180 degrees.
    testing::see(texture, {0.05F, 0.05F}, {0.45F, 0.25F}, {0.2F, 0, 0});
    testing::see(texture, {0.05F, 0.25F}, {0.45F, 0.45F}, {0.8F, 0, 0});
    const Raster8 image = baked(texture, testing::two_chart_wall());
    // Beside the seam (u = 0.9 in the right chart), v = 0.4 is the wall's bottom.
    CHECK(red(image, 0.88F, 0.38F) < 70);
    CHECK(red(image, 0.88F, 0.12F) > 185);
    // The nearest texels across the gutter (u = 0.6) belong to the wall's far end: mixed.
    const int far_bottom = red(image, 0.62F, 0.38F);
    CHECK(far_bottom > 80);
    CHECK(far_bottom < 130);
}

TEST_CASE_METHOD(BakeTest, "between two seen strips the fill runs smoothly from one to the other")
{
    testing::see(texture, {0.0F, 0.0F}, {0.15F, 0.5F}, {0.2F, 0, 0});   // the wall's left end
    testing::see(texture, {0.55F, 0.0F}, {0.65F, 0.5F}, {0.8F, 0, 0});  // and its right end: u = 0.6 .. 0.65 of the turned chart
    const Raster8 image = baked(texture, testing::two_chart_wall());
    // A harmonic function of the distance along the wall: linear between x = 1/6 m and x = 11/6 m.
    int previous = -1;
    for (int i = 0; i < 20; ++i)
    {
        const double wall_x = 1.0 / 6 + (i + 0.5) / 20 * 10 / 6;
        const double u = wall_x < 1 ? 0.1 + 0.3 * wall_x : 0.9 - 0.3 * (wall_x - 1);
        const int value = red(image, static_cast<float>(u), 0.25F);
        const double expected = 255 * (0.2 + 0.6 * (wall_x - 1.0 / 6) / (10.0 / 6));
        INFO("at " << wall_x << " m");
        CHECK(std::abs(value - expected) < 8);
        CHECK(value >= previous);
        previous = value;
    }
}

TEST_CASE_METHOD(BakeTest, "a part that joins no seen surface takes what is nearest in space")
{
    // Two more squares, far from each other in space, beside each other in the atlas; only the wall is seen.
    Mesh mesh = testing::two_chart_wall();
    testing::see(texture, {0.05F, 0.05F}, {0.45F, 0.45F}, {0.2F, 0, 0});
    testing::see(texture, {0.55F, 0.05F}, {0.95F, 0.45F}, {0.8F, 0, 0});
    for (const float x : {-0.5F, 2.2F})
    {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const Vec3f p : {Vec3f{x, 0, 0.1F}, {x + 0.3F, 0, 0.1F}, {x, 0.3F, 0.1F}})
            mesh.positions.push_back(p);
        mesh.triangles.push_back({first, first + 1, first + 2});
        // The square near the wall's right end lies above the left chart, and the other way round.
        const float u = x < 0 ? 0.6F : 0.1F;
        for (const Vec2f uv : {Vec2f{u, 0.6F}, {u + 0.3F, 0.6F}, {u, 0.9F}})
            mesh.texcoords.push_back(uv);
    }
    const Raster8 image = baked(texture, mesh);
    CHECK(red(image, 0.68F, 0.68F) == 51);
    CHECK(red(image, 0.18F, 0.68F) == 204);
}

TEST_CASE("unseen texels can be kept, seen ones stay what they are")
{
    Texture texture = testing::blank_texture(size, 0.6F);
    testing::see(texture, {0.1F, 0.1F}, {0.25F, 0.4F}, {0.2F, 0.2F, 0.2F});
    const Mesh mesh = testing::two_chart_wall();
    const Raster8 kept = baked(texture, mesh, Unseen::keep);
    CHECK(red(kept, 0.75F, 0.25F) == 153);
    CHECK(red(kept, 0.15F, 0.25F) == 51);
    CHECK(red(kept, 0.02F, 0.25F) == 51);  // the gutter beside the seen half
    const Raster8 filled = baked(texture, mesh);
    CHECK(red(filled, 0.15F, 0.25F) == 51);
}

TEST_CASE("optimized texels next to a chart are kept, those further out are gutter")
{
    Texture texture = testing::blank_texture(size, 0.6F);
    testing::see(texture, {0.0F, 0.0F}, {1.0F, 1.0F}, {0.2F, 0.2F, 0.2F});  // everything is marked as seen
    const auto darken = [&](int x, int y) { texture.layers[0].at(x, y, 0) = 0; };
    for (int y = 0; y < size; ++y)
        for (const int x : {6, 7})  // the left chart's texels begin at x = 8
            darken(x, y);
    darken(20, 20);  // far from any chart
    const Raster8 image = baked(texture, testing::two_chart_wall());
    CHECK(image.at(8, 60) == 51);
    CHECK(image.at(7, 60) == 0);  // bilinear lookups at the border read it
    CHECK(image.at(6, 60) == 0);  // as its nearest source
    CHECK(image.at(20, 20) == 51);
}

TEST_CASE("nothing to fill from is an error with the way out")
{
    CHECK_THROWS_WITH(baked(testing::blank_texture(size, 0.5F), testing::two_chart_wall()), Contains("unseen: keep"));
    CHECK_NOTHROW(baked(testing::blank_texture(8, 0.5F), testing::two_chart_wall(), Unseen::keep));
}

namespace
{
std::shared_ptr<const TexturedMesh> baked(const Value& options, const Texture& texture, const Mesh& mesh, testing::TestRun& run)
{
    return testing::output_of<TexturedMesh>(
        "texture.bake", "textured_mesh", options,
        {{"texture", std::make_shared<Texture>(texture)}, {"mesh", std::make_shared<Mesh>(mesh)}}, run);
}
}  // namespace

TEST_CASE_METHOD(testing::StageTest, "the stage gives the mesh its picture and reports the shares")
{
    Texture texture = testing::blank_texture(80, 0.0F);
    testing::see(texture, {0.0F, 0.0F}, {0.5F, 0.5F}, {0.2F, 0.4F, 0.6F});
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

TEST_CASE_METHOD(testing::StageTest, "the stage refuses what it cannot use")
{
    const Texture texture = testing::blank_texture(16, 0.5F);
    Mesh bare = testing::two_chart_wall();
    bare.texcoords.clear();
    CHECK_THROWS_WITH(baked(Value::Map{}, texture, bare, run), Contains("no texcoords"));

    run.cancel_after(2);
    CHECK_THROWS_AS(baked(Value::Map{{"unseen", "keep"}}, texture, testing::two_chart_wall(), run), Canceled);
}
