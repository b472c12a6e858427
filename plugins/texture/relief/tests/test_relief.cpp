#include "catch.h"
#include "plugin_under_test.h"
#include "relief.h"

#include <fresco/random.h>
#include <fresco/testing_scenes.h>
#include <fresco/texture.h>
#include <fresco/texturing/exports.h>
#include <fresco/texturing/relief_maps.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

constexpr int size_px = 256;
constexpr double degree = std::numbers::pi / 180;

/// A sheet of 2 m x 1 m in two charts that meet at x = 1: the left one turned by 20 degrees, the right one mirrored, turned by
/// -70 degrees and smaller. `flat`: its x and y; `bent`: the same, round a cylinder.
struct Sheet
{
    static constexpr double radius = 0.5;
    Mesh flat;
    Mesh bent;

    Sheet()
    {
        flat = testing::rectangle({}, {2, 0, 0}, {0, 1, 0}, 80, 20);
        for (const Triangle& t : flat.triangles)
            for (const std::uint32_t v : t)
                flat.texcoords.push_back(texcoord(flat.positions[v], t[0] % 81 >= 40));
        bent = flat;
        for (Vec3f& p : bent.positions)
            p = {static_cast<float>(radius * std::sin((p.x - 1) / radius)), p.y,
                 static_cast<float>(radius * std::cos((p.x - 1) / radius))};
    }

    static Vec2f texcoord(Vec3f p, bool right)
    {
        const double angle = (right ? -70 : 20) * degree;
        const double x = right ? 1.5 - double{p.x} : double{p.x} - 0.5;
        const double y = double{p.y} - 0.5;
        const double scale = right ? 0.3 : 0.35;
        return {static_cast<float>((right ? 0.74 : 0.27) + scale * (std::cos(angle) * x - std::sin(angle) * y)),
                static_cast<float>(0.5 + scale * (std::sin(angle) * x + std::cos(angle) * y))};
    }
};

/// Waves of about 32 texels, two strokes at 2 mm a texel, up to 15 degrees steep; centered between 0 and 4 cm.
double wave_height(double x, double y)
{
    return 0.02 + 0.016 * std::sin(16 * x + 3) * std::cos(9 * y) + 0.003 * std::sin(16 * y);
}

Vec3d expected_normal(double x, double y)
{
    const double turn = (x - 1) / Sheet::radius;
    const Vec3d out{std::sin(turn), 0, std::cos(turn)}, along{std::cos(turn), 0, -std::sin(turn)};
    // The derivatives of the height.
    const Vec2d slope{0.256 * std::cos(16 * x + 3) * std::cos(9 * y),
                      -0.144 * std::sin(16 * x + 3) * std::sin(9 * y) + 0.048 * std::cos(16 * y)};
    return normalized(out - along * slope.x - Vec3d{0, slope.y, 0});
}

/// A renderer: looks the map up between texels and turns it by the frame that it interpolates.
class Renderer
{
  public:
    Renderer(const Mesh& mesh, const Raster8& normals) : mesh_(mesh), welded_(weld(mesh)), map_(normals.width, normals.height, 3)
    {
        add_tangents(welded_);
        for (std::size_t i = 0; i < map_.values.size(); ++i)
            map_.values[i] = static_cast<float>(normals.values[i]) / 127.5F - 1;
    }

    Vec3d normal(std::size_t face, const std::array<double, 3>& weights) const
    {
        Vec2d uv;
        Vec3d normal, tangent;
        double handed = 0;
        for (std::size_t i = 0; i < 3; ++i)
        {
            const std::uint32_t v = welded_.indices[3 * face + i];
            const auto& [x, y, z, w] = welded_.tangents[v];
            uv = uv + Vec2d{double{mesh_.texcoords[3 * face + i].x}, double{mesh_.texcoords[3 * face + i].y}} * weights[i];
            normal += vec_cast<double>(welded_.normals[v]) * weights[i];
            tangent += Vec3d{double{x}, double{y}, double{z}} * weights[i];
            handed = double{w};
        }
        normal = normalized(normal);
        tangent = normalized(tangent);
        std::array<float, 3> n{};
        sample_bilinear(map_, static_cast<float>(uv.x), static_cast<float>(uv.y), n.data());
        return normalized(tangent * double{n[0]} + cross(normal, tangent) * (handed * double{n[1]}) + normal * double{n[2]});
    }

  private:
    const Mesh& mesh_;
    WeldedMesh welded_;
    RasterF map_;
};

double angle_deg(Vec3d a, Vec3d b)
{
    return std::asin(std::min(length(cross(a, b)), 1.0)) / degree;
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest, "decoded normals are those of the height, to a degree, also beside a seam")
{
    const Sheet sheet;
    const Charts charts = find_charts(sheet.bent);
    REQUIRE(charts.count == 2);
    const TexelFaces faces = find_texel_faces(sheet.bent, charts, size_px, run);
    RasterF height(size_px, size_px);
    for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        if (faces.covered(texel))
        {
            const Vec3f p = texel_position(sheet.flat, faces, texel);
            height.values[texel] = static_cast<float>(wave_height(double{p.x}, double{p.y}));
        }
    const Relief relief = relief_of(height, sheet.bent, charts, faces, 0.04, run);
    const Renderer renderer(sheet.bent, tangent_maps(relief, sheet.bent, 0, run).normals);
    double worst = 0;
    Random random(5);
    for (std::size_t face = 0; face < sheet.bent.triangles.size(); ++face)
        for (int i = 0; i < 20; ++i)
        {
            double a = random.uniform(), b = random.uniform();
            if (a + b > 1)
                a = 1 - a, b = 1 - b;
            const std::array weights{1 - a - b, a, b};
            double x = 0, y = 0;
            for (std::size_t k = 0; k < 3; ++k)
            {
                x += weights[k] * double{sheet.flat.positions[sheet.flat.triangles[face][k]].x};
                y += weights[k] * double{sheet.flat.positions[sheet.flat.triangles[face][k]].y};
            }
            // At the sheet's border, one side of the height is unknown.
            if (std::min({x, 2 - x, y, 1 - y}) > 0.06)
                worst = std::max(worst, angle_deg(renderer.normal(face, weights), expected_normal(x, y)));
        }
    CHECK(worst < 1);
}

namespace
{

/// The heights along the middle row of a wall 2 m wide whose light is a wave of `period_m`: lowest and highest, in millimeters.
std::pair<double, double> heights_mm(int texels, double period_m, double amplitude)
{
    testing::TestRun run;
    Mesh mesh = testing::wall(1);
    const Raster8 rgb = testing::picture(texels, texels,
                                         [&](int x, int, int)
                                         {
                                             const double at_m = 2 * (x + 0.5) / texels;
                                             return 120 + amplitude * std::sin(2 * std::numbers::pi * at_m / period_m) +
                                                    20 * std::sin(2 * std::numbers::pi * at_m / 0.08);
                                         });
    const TexelFaces faces = find_texel_faces(mesh, find_charts(mesh), texels, run);
    const RasterF height = paint_height(rgb, mesh, faces, 0.002, 0.04, run);
    const auto row = std::span(height.values)
                         .subspan(static_cast<std::size_t>(texels) * static_cast<std::size_t>(texels / 2) +
                                      static_cast<std::size_t>(texels / 4),
                                  static_cast<std::size_t>(texels / 2));
    const auto [low, high] = std::ranges::minmax(row);
    return {1000 * double{low}, 1000 * double{high}};
}

}  // namespace

TEST_CASE_METHOD(testing::StageTest,
                 "lighter strokes are thicker, at every texture size alike, and patterns wider than two strokes add nothing")
{
    // The crest of a sine is sqrt(2) times its root mean square, so the height there is 1 + 1.41 / sqrt(1.41^2 + 2^2) mm. The
    // margin is for the grid of the mean, which changes waves of its own size a little.
    for (const int texels : {256, 512})
    {
        const auto [low, high] = heights_mm(texels, 1, 0);
        CHECK(high == Approx(1.577).margin(0.06));
        CHECK(low == Approx(0.423).margin(0.06));
        // Waves of 25 strokes below change nothing.
        const auto [low_over, high_over] = heights_mm(texels, 1, 60);
        CHECK(high_over == Approx(high).margin(0.05));
        CHECK(low_over == Approx(low).margin(0.05));
    }
    const Mesh mesh = testing::wall(1);
    const TexelFaces faces = find_texel_faces(mesh, find_charts(mesh), 64, run);
    const RasterF flat = paint_height(Raster8(64, 64, 3, 77), mesh, faces, 0.002, 0.04, run);
    CHECK(std::ranges::all_of(flat.values, [](float h) { return std::abs(h - 0.001F) < 1e-6F; }));
}

TEST_CASE("a smaller relief averages the normals that are known, and only those")
{
    Relief relief;
    relief.normals = Raster16(8, 8, 3);
    relief.roughness = Raster8(8, 8);
    const auto tilt = [](std::size_t texel) { return texel % 2 == 0 ? Vec3f{0.6F, 0, 0.8F} : Vec3f{-0.6F, 0, 0.8F}; };
    for (const std::size_t texel : {0, 1, 8, 9, 2, 10, 3})
    {
        relief.set_normal(texel, tilt(texel));
        relief.roughness.values[texel] = static_cast<std::uint8_t>(100 + texel);
    }
    const ReliefMaps maps = world_maps(relief, 4, Progress());
    REQUIRE(maps.normals.width == 4);
    const auto normal = [&](int x, int y) {
        return std::array{maps.normals.at(x, y, 0), maps.normals.at(x, y, 1), maps.normals.at(x, y, 2)};
    };
    const auto expected = [](double x, double z)
    {
        const auto step = [&](double v) { return static_cast<std::uint8_t>(std::lround(127.5 * (v / std::hypot(x, z) + 1))); };
        return std::array{step(x), step(0), step(z)};
    };
    CHECK(normal(0, 0) == expected(0, 0.8));
    CHECK(maps.roughness.at(0, 0) == std::lround((100 + 101 + 108 + 109) / 4.0));
    CHECK(normal(1, 0) == expected(0.6 / 3, 0.8));
    CHECK(maps.roughness.at(1, 0) == 105);
    // The gutter has a neighbor's.
    CHECK(normal(3, 3) == normal(1, 0));
}

namespace
{

Relief made(const testing::Inputs& inputs, double stroke_cm, testing::TestRun& run)
{
    return *testing::output_of<Relief>("texture.relief", "relief", Value::Map{{"stroke_cm", stroke_cm}}, inputs, run);
}

Relief made(const testing::Inputs& inputs, double stroke_cm = 1)
{
    testing::TestRun run;
    return made(inputs, stroke_cm, run);
}

TexturedMesh textured_in(const testing::Inputs& inputs)
{
    return dynamic_cast<const TexturedMesh&>(*inputs.at("textured_mesh"));
}

/// A wall with a picture, and the map that says that the picture was copied to it as it is.
testing::Inputs painted_wall()
{
    const auto textured = std::make_shared<TexturedMesh>();
    textured->mesh = testing::wall(0.1F);
    textured->image = Image(testing::noise_picture(64, 64, 3));
    const auto source = std::make_shared<SourceMap>();
    source->atlas = atlas_id(textured->mesh);
    source->picture_width = source->picture_height = 64;
    source->clear(64);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            source->set_place(x, y, {{static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F}});
    return {{"textured_mesh", textured}, {"source", source}, {"style", std::make_shared<Image>(textured->image)}};
}

}  // namespace

TEST_CASE("through the source map the picture's own detail counts, not the painting's")
{
    testing::Inputs inputs = painted_wall();
    const Relief from_picture = made(inputs);
    const auto blended = std::make_shared<TexturedMesh>(textured_in(inputs));
    const Raster8 picture = blended->image.pixels;
    blended->image = Image(testing::picture(
        64, 64, [&](int x, int y, int c) { return 0.85 * picture.at(x, y, c) + 0.15 * picture.at((x + 1) % 64, y, c); }));
    inputs["textured_mesh"] = blended;
    CHECK(made(inputs).normals == from_picture.normals);
    inputs.erase("source");
    inputs.erase("style");
    CHECK(made(inputs).normals != from_picture.normals);
}

namespace
{

/// The wall of painted_wall, which shows something else from column `first` on: `right` of the picture's value and another one.
testing::Inputs half_painted_wall(const std::function<double(double, double)>& right, int first = 32)
{
    testing::Inputs inputs = painted_wall();
    const auto textured = std::make_shared<TexturedMesh>(textured_in(inputs));
    const Raster8 picture = textured->image.pixels;
    const Raster8 other = testing::noise_picture(64, 64, 8);
    textured->image = Image(testing::picture(64, 64,
                                             [&](int x, int y, int c)
                                             {
                                                 const double own = picture.at(x, y, c);
                                                 return x < first ? own : right(own, other.at(x, y, c));
                                             }));
    inputs["textured_mesh"] = textured;
    return inputs;
}

/// The texels of a quarter of the width, from column `first` on, for which `test` does not hold.
template <class Test>
int unlike(int first, const Test& test)
{
    int count = 0;
    for (std::size_t y = 0; y < 64; ++y)
        for (int x = first; x < first + 16; ++x)
            count += test(64 * y + static_cast<std::size_t>(x)) ? 0 : 1;
    return count;
}

}  // namespace

TEST_CASE("relief lies where the picture's strokes are shown, and not where the photo or another painting is")
{
    const auto equal = [](const Relief& a, const Relief& b)
    { return [&a, &b](std::size_t t) { return a.normal(t) == b.normal(t) && a.roughness.values[t] == b.roughness.values[t]; }; };
    const Relief whole = made(painted_wall(), 0.4);
    const Relief half = made(half_painted_wall([](double, double other) { return other; }), 0.4);
    CHECK(unlike(0, equal(half, whole)) == 0);
    const Vec3f outward = face_normals(testing::wall(0.1F)).front();
    const auto is_bare = [&](std::size_t t)
    { return dot(half.normal(t), outward) > 0.99999F && half.roughness.values[t] == 217; };
    CHECK(unlike(48, is_bare) == 0);
    CHECK(unlike(48, equal(whole, half)) > 900);
    // Strokes of which a fifth was taken for the photo are still strokes.
    const Relief mixed = made(half_painted_wall([](double own, double other) { return 0.8 * own + 0.2 * other; }), 0.4);
    CHECK(unlike(48, equal(mixed, whole)) == 0);
}

TEST_CASE("a weaker mixture has less relief; where hardly any is left, or the style is another one, a warning says so")
{
    const auto strength_of = [](const testing::Inputs& inputs, std::string& message)
    {
        testing::TestRun run;
        made(inputs, 0.4, run);
        message = run.messages.empty() ? "" : run.messages.front();
        return run.reported.at("shown_share").as_double();
    };
    // The photo has 0.3 of the picture's contrast.
    const auto mixed = [](double strength)
    {
        return half_painted_wall(
            [strength](double own, double other) { return strength * own + (1 - strength) * (128 + 0.3 * (other - 128)); }, 0);
    };
    std::string message;
    CHECK(strength_of(mixed(1), message) > 0.99);
    CHECK(message.empty());
    const double half = strength_of(mixed(0.5), message);
    CHECK(half == Approx(0.5 / 0.65).margin(0.08));
    CHECK_THAT(message, Catch::StartsWith("the relief is 7") && Catch::Contains("% of full strength on average"));
    const double third = strength_of(mixed(1 / 3.0), message);
    CHECK(third > 0.01);
    CHECK(third < 0.6 * half);
    CHECK(strength_of(mixed(0.15), message) < 0.01);
    CHECK_THAT(message, Catch::StartsWith("warning: hardly any of the surface shows strokes of the picture on port 'style'"));
    testing::Inputs of_another = painted_wall();
    of_another["style"] = std::make_shared<Image>(testing::noise_picture(64, 64, 8));
    strength_of(of_another, message);
    CHECK_THAT(message, Catch::StartsWith("warning: hardly any of the surface"));
}

TEST_CASE("relief: what does not fit together is refused")
{
    const testing::Inputs whole = painted_wall();
    const auto refused = [&](const char* port, std::shared_ptr<const Artifact> other, const char* message)
    {
        testing::Inputs inputs = whole;
        inputs.erase(port);
        if (other)
            inputs[port] = std::move(other);
        CHECK_THROWS_WITH(made(inputs), Catch::Contains(message));
    };
    refused("style", nullptr, "port 'source' needs port 'style'");
    refused("source", nullptr, "port 'style' is used only with port 'source'");
    const auto source = std::make_shared<SourceMap>(dynamic_cast<const SourceMap&>(*whole.at("source")));
    source->atlas = "0123";
    refused("source", source, "the source map on port 'source'");
    refused("style", std::make_shared<Image>(Raster8(64, 32, 3)), "64x32 pixels");
    const auto small = std::make_shared<TexturedMesh>(textured_in(whole));
    small->image = Image(Raster8(32, 32, 3));
    refused("textured_mesh", small, "has 32 texels a side");
}
