#include "catch.h"
#include "painted_wall.h"
#include "painting.h"

#include <fresco/error.h>
#include <fresco/rendering/view_renderer.h>
#include <fresco/splats/render_splats.h>
#include <fresco/testing.h>

using namespace fresco;
using namespace painted_wall;
using export_splats::paint;
using export_splats::Painting;

namespace
{

/// Sees the middle of the wall.
Camera camera()
{
    return {{100, 100, 150, 150, 50, 50}, {}};
}

splats::Splats painted(const splats::Splats& splats, const Painting& painting)
{
    splats::Splats result;
    for (const auto& part : painting.splats.parts)
    {
        result.centers.push_back(part.is_split ? part.center : splats.centers[part.source]);
        result.rotations.push_back(splats.rotations[part.source]);
        result.scales.push_back(part.is_split ? part.scale : splats.scales[part.source]);
        result.opacities.push_back(part.is_split ? part.opacity : splats.opacities[part.source]);
        result.colors.push_back(part.keeps_color ? splats.colors[part.source] : part.color);
    }
    return result;
}

/// Mean difference of two pictures of three channels, in 255ths.
double difference(const RasterF& a, const RasterF& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i)
        sum += std::abs(static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]));
    return 255 * sum / static_cast<double>(a.values.size());
}

RasterF picture(const splats::Splats& splats, const Camera& from = camera())
{
    return render_splats(splats, from, 0.1, testing::TestRun()).color;
}

RasterF mesh_picture(const TexturedMesh& textured)
{
    const Raster8 rendered =
        rendering::ViewRenderer(textured, {.filter = rendering::TextureFilter::trilinear}).render(camera(), testing::TestRun());
    RasterF result(rendered.width, rendered.height, 3);
    for (int y = 0; y < rendered.height; ++y)
        for (int x = 0; x < rendered.width; ++x)
            for (int c = 0; c < 3; ++c)
                result.at(x, y, c) = static_cast<float>(rendered.at(x, y, c)) / 255;
    return result;
}

}  // namespace

TEST_CASE("Gaussians take the color of the nearest surface, in the splat's units and far from 0")
{
    splats::Splats splats;
    add(splats, {0.125F, -0.25F, 1}, {0.002F, 0.002F, 0.001F}, 0.5F);
    add(splats, {0.3F, 0.1F, 1.05F}, {0.002F, 0.001F, 0.002F}, 0.5F);
    add(splats, {-0.3F, 0.1F, 0.4F}, {0.001F, 0.001F, 0.001F}, 0.5F);  // A floater.
    const TexturedMesh textured = wall();
    const Painting painting = paint(splats, textured, {.stroke_m = stroke_m}, testing::TestRun());
    REQUIRE(painting.splats.parts.size() == 3);
    CHECK(painting.split == 0);
    CHECK(painting.unpainted == 1);
    CHECK(painting.splats.parts[2].keeps_color);
    for (std::size_t i = 0; i < 2; ++i)
    {
        const Vec3f c = splats.centers[i];
        CHECK(length(vec_cast<double>(painting.splats.parts[i].color) - color(double{c.x}, double{c.y})) < 0.01);
        CHECK(!painting.splats.parts[i].is_split);
    }
    TexturedMesh moved = textured;
    moved.mesh.offset_m = {1000, -200, 0};
    for (std::size_t i = 0; i < splats.size(); ++i)
    {
        splats.centers[i] = (splats.centers[i] + Vec3f{1000, -200, 0}) * 100;
        splats.scales[i] = splats.scales[i] * 100;
    }
    const Painting far = paint(splats, moved, {.unit_m = 0.01, .stroke_m = stroke_m}, testing::TestRun());
    for (std::size_t i = 0; i < 3; ++i)
        CHECK(length(far.splats.parts[i].color - painting.splats.parts[i].color) < 0.01);
    CHECK(far.unpainted == 1);
}

TEST_CASE("Gaussians beside the surface show its mean color without strokes, those that do not reach it keep theirs")
{
    splats::Splats splats;
    add(splats, {0.7F, 0, 1}, {0.1F, 0.1F, 0.01F}, 0.5F);  // Beside the border, where the stripes are 0.18 from their mean.
    add(splats, {0.7F, 0, 1}, {0.02F, 0.1F, 0.1F}, 0.5F);  // Narrow along the way to the border.
    add(splats, {0, 0, 1.3F}, {0.1F, 0.1F, 0.02F}, 0.5F);  // Flat in front of the wall.
    add(splats, {0.45F, 0, 1}, {0.05F, 0.05F, 0.01F}, 0.5F);
    const Painting painting = paint(splats, wall(), {.stroke_m = stroke_m}, testing::TestRun());
    const auto& parts = painting.splats.parts;
    REQUIRE(parts.size() > 4);
    CHECK(painting.split == 1);
    CHECK(painting.unpainted == 2);
    CHECK(length(parts[0].color - Vec3f{0.5F, 0.5F, 0.4F}) < 0.08F);
    for (const std::size_t i : {1, 2})
        CHECK(parts[i].keeps_color);
    CHECK(parts[3].is_split);
}

TEST_CASE("Large Gaussians are split along the surface, and the picture stays as it was")
{
    const auto gray = [](double, double) { return Vec3d{0.9, 0.6, 0.3}; };
    const TexturedMesh textured = wall(gray);
    const double limit = stroke_m / 8;
    splats::Splats slight;
    add(slight, {0, 0, 1}, {static_cast<float>(1.3 * limit), static_cast<float>(1.3 * limit), 0.03F}, 0.5F);
    const Painting four = paint(slight, textured, {.stroke_m = stroke_m}, testing::TestRun());
    CHECK(four.splats.parts.size() == 4);  // Not along the normal, where it is large, too.
    CHECK(four.split == 1);
    for (const auto& part : four.splats.parts)
    {
        CHECK(part.scale.x <= static_cast<float>(limit));
        CHECK(part.scale.z == 0.03F);
    }
    CHECK(paint(slight, textured, {.stroke_m = stroke_m, .densify = false}, testing::TestRun()).splats.parts.size() == 1);

    const float half = std::sqrt(0.5F);
    splats::Splats large;
    add(large, {-0.12F, 0, 1}, {0.06F, 0.03F, 1e-4F}, 0.4F);
    add(large, {0.1F, 0.1F, 1}, {1e-4F, 0.05F, 0.02F}, 0.97F, {half, 0, half, 0});
    add(large, {0.1F, -0.15F, 1}, {0.05F, 0.05F, 0.02F}, 0.8F);
    large.colors.assign(3, {0.9F, 0.6F, 0.3F});
    const Painting many = paint(large, textured, {.stroke_m = stroke_m}, testing::TestRun());
    CHECK(many.split == 3);
    CHECK(many.splats.parts.size() > 60);
    CHECK(many.splats.parts.size() < 400);
    // So near that the pixel's own filter does not widen the parts.
    const Camera near{{400, 400, 600, 600, 200, 200}, {}};
    const RasterF before = picture(large, near);
    const RasterF after = picture(painted(large, many), near);
    CAPTURE(many.splats.parts.size());
    const double brightness = difference(before, RasterF(before.width, before.height, 3));
    CHECK(brightness > 5);
    CHECK(difference(before, after) < 0.15 * brightness);
    CHECK(difference(after, RasterF(after.width, after.height, 3)) == Approx(brightness).epsilon(0.03));
}

TEST_CASE("A painting that is turned over, with its parts, looks the same to a camera that turned along")
{
    splats::Splats splats;
    for (int i = 0; i < 12; ++i)
    {
        const double turn = 0.4 * i;
        add(splats, {0.05F * static_cast<float>(i % 4 - 2), 0.06F * static_cast<float>(i / 4 - 1), 1},
            {0.01F + 0.004F * static_cast<float>(i), 0.01F, 0.004F}, 0.7F,
            {static_cast<float>(std::cos(turn)), static_cast<float>(0.48 * std::sin(turn)),
             static_cast<float>(0.6 * std::sin(turn)), static_cast<float>(0.64 * std::sin(turn))});
    }
    Painting painting = paint(splats, wall(), {.stroke_m = stroke_m}, testing::TestRun());
    CHECK(painting.split > 3);
    CHECK(painting.split < splats.size());
    const RasterF before = picture(painted(splats, painting));
    export_splats::turn_over(splats, painting.splats);
    Camera turned = camera();
    turned.world_from_camera.rotation = {{1, 0, 0, 0, -1, 0, 0, 0, -1}};
    CHECK(difference(before, RasterF(before.width, before.height, 3)) > 2);
    CHECK(difference(before, picture(painted(splats, painting), turned)) < 0.01);
}

TEST_CASE("A covered wall looks as the painted mesh does")
{
    const TexturedMesh textured = wall();
    const RasterF truth = mesh_picture(textured);
    const splats::Splats fine = covering(stroke_m / 8, 0.6F, stroke_m / 8.5);
    const Painting painting = paint(fine, textured, {.stroke_m = stroke_m}, testing::TestRun());
    CHECK(painting.split == 0);
    CHECK(difference(picture(painted(fine, painting)), truth) <= 4);
    CHECK(difference(picture(fine), truth) > 60);

    // Only splitting makes strokes of coarse ones.
    const splats::Splats coarse = covering(0.8 * stroke_m);
    const auto left = paint(coarse, textured, {.stroke_m = stroke_m, .densify = false}, testing::TestRun());
    const auto split = paint(coarse, textured, {.stroke_m = stroke_m}, testing::TestRun());
    CHECK(split.split == coarse.size());
    CHECK(difference(picture(painted(coarse, left)), truth) > 12);
    CHECK(difference(picture(painted(coarse, split)), truth) < 6);
}

TEST_CASE("A footprint wider than the texels is averaged")
{
    const auto texels = [](double x, double y)
    {
        const auto odd = static_cast<int>(std::floor(x * 256)) + static_cast<int>(std::floor(y * 256));
        return odd % 2 == 0 ? Vec3d{1, 1, 1} : Vec3d{0, 0, 0};
    };
    splats::Splats splats;
    add(splats, {0.1F, 0.1F, 1}, {0.01F, 0.01F, 1e-4F}, 0.5F);
    add(splats, {0.1F, 0.1F, 1}, {0.1F, 0.1F, 1e-4F}, 0.5F);
    const Painting painting = paint(splats, wall(texels), {.stroke_m = stroke_m, .densify = false}, testing::TestRun());
    for (const auto& part : painting.splats.parts)
        CHECK(length(part.color - Vec3f{0.5F, 0.5F, 0.5F}) < 0.01F);
}

TEST_CASE("Any number of threads paints the same, and too many parts are refused")
{
    const TexturedMesh textured = wall();
    const splats::Splats coarse = covering(stroke_m / 3);
    const splats::Splats fine = covering(0.01);
    for (const splats::Splats* each : {&coarse, &fine})
    {
        const auto one = paint(*each, textured, {.stroke_m = stroke_m}, testing::TestRun(1));
        CHECK(paint(*each, textured, {.stroke_m = stroke_m}, testing::TestRun(3)).splats.parts == one.splats.parts);
    }
    CHECK_THROWS_WITH(paint(coarse, textured, {.stroke_m = stroke_m, .most_parts = 1000}, testing::TestRun()),
                      Contains("use a larger stroke_cm"));
}
