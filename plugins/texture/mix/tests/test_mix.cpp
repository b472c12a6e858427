#include "catch.h"
#include "mix.h"
#include "mixture.h"
#include "plugin_under_test.h"

#include <fresco/testing.h>
#include <fresco/testing_scenes.h>
#include <fresco/texturing/surface_average.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace fresco;
using namespace fresco::texturing;

namespace
{
constexpr int wall_px = 160;

TexelFaces wall_faces()
{
    const Mesh mesh = testing::two_chart_wall();
    return find_texel_faces(mesh, find_charts(mesh), wall_px, testing::TestRun());
}

/// A function of the place on the wall (0 to 2 m, 0 to 1 m), gray.
template <class Function>
RasterF painted_by(Function value)
{
    const Mesh mesh = testing::two_chart_wall();
    const TexelFaces faces = wall_faces();
    RasterF rgb(wall_px, wall_px, 3, 0.5F);
    for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        if (faces.covered(texel))
        {
            const Vec3f at = texel_position(mesh, faces, texel);
            for (std::size_t c = 0; c < 3; ++c)
                rgb.values[3 * texel + c] = static_cast<float>(value(at));
        }
    return rgb;
}

Mix mixed(const RasterF& photo, const RasterF& painting, double color, double strokes)
{
    return mix(photo, painting, testing::two_chart_wall(), wall_faces(), 0.3, {color, strokes}, testing::TestRun());
}

/// 1 m², all normals differ, its border between texels.
Mesh hill()
{
    Mesh mesh = testing::grid(8, [](float x, float y) { return 0.2F * std::sin(5 * x) * std::cos(4 * y); });
    testing::set_texcoords(mesh, [](Vec3f p) { return Vec2f{0.0523F + 0.9F * p.x, 0.0517F + 0.9F * p.y}; });
    return mesh;
}

RasterF noise(unsigned seed)
{
    const Raster8 steps = testing::noise_picture(wall_px, wall_px, seed);
    RasterF rgb(wall_px, wall_px, 3);
    std::ranges::transform(steps.values, rgb.values.begin(), [](std::uint8_t step) { return static_cast<float>(step) / 255; });
    return rgb;
}

double long_wave(Vec3f at)
{
    return 0.2 * std::sin(2 * std::numbers::pi * at.x / 1.5);
}
double short_wave(Vec3f at)
{
    return 0.2 * std::sin(2 * std::numbers::pi * at.y / 0.08);
}

}  // namespace

TEST_CASE("mix: both ends are the textures themselves, and equal shares a straight line between them")
{
    const RasterF photo = painted_by([](Vec3f at) { return 0.5 + long_wave(at); });
    const RasterF painting = painted_by([](Vec3f at) { return 0.4 + short_wave(at); });
    CHECK(mixed(photo, painting, 0, 0).rgb == photo);
    CHECK(mixed(photo, painting, 1, 1).rgb == painting);
    const Mix middle = mixed(photo, painting, 0.5, 0.5);
    const TexelFaces faces = wall_faces();
    double largest = 0, sum = 0, count = 0;
    for (std::size_t i = 0; i < photo.values.size(); ++i)
    {
        const double a = double{photo.values[i]}, b = double{painting.values[i]};
        largest = std::max(largest, std::abs(double{middle.rgb.values[i]} - (a + b) / 2));
        sum += faces.inside[i / 3] ? std::abs(255 * (a - b) / 2) : 0;
        count += faces.inside[i / 3] ? 1 : 0;
    }
    CHECK(largest < 1e-6);
    CHECK(middle.from_photo == Approx(sum / count));
    CHECK(middle.from_painted == Approx(sum / count));
}

TEST_CASE("mix: the mean along rows is that of each texel by itself")
{
    const Mesh mesh = hill();
    const TexelFaces faces = find_texel_faces(mesh, find_charts(mesh), wall_px, testing::TestRun());
    const RasterF photo = noise(1);
    const RasterF painting = noise(2);
    const auto normals = vertex_normals(mesh);
    const auto normal = [&](std::size_t texel)
    {
        const auto weights = texel_weights(mesh, faces, texel);
        Vec3f sum;
        for (std::size_t i = 0; i < 3; ++i)
            sum += normals[mesh.triangles[faces.face[texel]][i]] * static_cast<float>(weights[i]);
        return normalized(sum);
    };
    const auto color = [](const RasterF& rgb, std::size_t texel) {
        return Vec3f{rgb.values[3 * texel], rgb.values[3 * texel + 1], rgb.values[3 * texel + 2]};
    };
    // So small a split that every texel is a sample.
    constexpr double split_m = 0.15;
    const auto [lowest, highest] = std::ranges::minmax(mesh.positions, {}, &Vec3f::z);
    SurfaceAverage average({0, 0, lowest.z}, {1, 1, highest.z}, split_m, "split_cm");
    for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        if (faces.inside[texel])
            average.add(texel_position(mesh, faces, texel), normal(texel), color(painting, texel) - color(photo, texel));

    const Mix mixed = mix(photo, painting, mesh, faces, split_m, {1, 0}, testing::TestRun());
    double largest = 0;
    double steps = 0;
    for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
    {
        Vec3f expected = color(photo, texel);
        if (faces.covered(texel))
            expected += SurfaceAverage::Lookup(average).at(texel_position(mesh, faces, texel), normal(texel), {});
        for (std::size_t c = 0; c < 3; ++c)
        {
            const double value = std::clamp(double{(&expected.x)[c]}, 0.0, 1.0);
            largest = std::max(largest, std::abs(double{mixed.rgb.values[3 * texel + c]} - value));
            steps = std::max(steps, std::abs(mixed.colors.values[3 * texel + c] - 255 * value));
        }
    }
    CHECK(largest < 1e-4);
    CHECK(steps < 0.51);
}

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
                                     const Mesh& mesh = testing::two_chart_wall(), const testing::TemporaryFolder& folder = {})
{
    testing::run_stage(FRESCO_PLUGIN_FILE, "texture.mix", options,
                       {{"photo", std::make_shared<Texture>(photo)},
                        {"painted", std::make_shared<Texture>(painted)},
                        {"mesh", std::make_shared<Mesh>(mesh)}},
                       folder.path(), run);
    return Texture::load({folder.path() / "texture", folder.path()});
}
}  // namespace

TEST_CASE_METHOD(testing::StageTest,
                 "the stage mixes and reports how far the mixture is from both, and the page can mix as it does", "[texture.mix]")
{
    // Two colors of the wall's halves and fine stripes: both bands differ.
    Texture photo = wall({0.2F, 0.4F, 0.6F});
    testing::see(photo, {0.5F, 0}, {1, 0.5F}, {0.5F, 0.3F, 0.2F});
    Texture painted = wall({0.6F, 0.3F, 0.4F});
    for (int x = 0; x < side; x += 4)
        for (int y = 0; y < side; ++y)
            painted.layers.front().at(x, y, 1) += 0.2F;
    const auto texture =
        mixed(Value::Map{{"color", 0.3}, {"strokes", 0.8}}, photo, painted, run, testing::two_chart_wall(), folder);
    const auto small = Mixture::load({folder.path() / "sliders", folder.path()});
    CHECK(texture->values == "display");
    CHECK(texture->atlas == atlas_id(testing::two_chart_wall()));
    CHECK(run.reported.at("from_photo").as_double() > 0);
    CHECK(run.reported.at("from_painted").as_double() > 0);
    CHECK(small->atlas == texture->atlas);
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

TEST_CASE_METHOD(testing::StageTest, "what one of the textures lacks is continued from its surroundings before mixing",
                 "[texture.mix]")
{
    Texture photo = testing::blank_texture(side, 0.0F);
    testing::see(photo, {0, 0}, {0.5F, 0.5F}, {0.2F, 0.2F, 0.2F});  // only the left chart
    const auto result = mixed(Value::Map{{"color", 0.5}, {"strokes", 0.5}}, photo, wall({0.6F, 0.6F, 0.6F}), run);
    CHECK(result->layers.front().at(3 * side / 4, 3 * side / 4, 0) == Approx(0.4));
    CHECK(result->seen.at(3 * side / 4, 3 * side / 4) == 1);
    CHECK(result->seen.at(side / 2, side / 4) == 0);
}

TEST_CASE_METHOD(testing::StageTest, "the stage refuses textures that do not belong together", "[texture.mix]")
{
    const Texture photo = wall({});
    CHECK_THROWS_WITH(mixed(Value::Map{}, photo, testing::blank_texture(side / 2, 0), run),
                      Catch::Contains("'photo' has 80 texels a side, the one on port 'painted' 40"));
    Texture other = photo;
    other.atlas = "00000000000000000000000000000000";
    CHECK_THROWS_WITH(mixed(Value::Map{}, photo, other, run), Catch::Contains("the texture on port 'painted'"));
    Mesh bare = testing::two_chart_wall();
    bare.texcoords.clear();
    CHECK_THROWS_WITH(mixed(Value::Map{}, photo, photo, run, bare), Catch::Contains("has no texcoords"));

    CHECK_THROWS_WITH(mixed(Value::Map{}, testing::blank_texture(side, 0), photo, run), Catch::Contains("seen"));
}
