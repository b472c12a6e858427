#include "catch.h"
#include "circles.h"
#include "judged_views.h"
#include "plugin_under_test.h"

#include <fresco/testing_scenes.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

using namespace fresco;
using fresco::testing::camera;

namespace
{

// Red discs on planes, seen by a camera; a slow, exact renderer.

struct Disc
{
    Vec3d center;       ///< On the plane.
    double radius = 0;  ///< Meters.
    Rgb8 color{230, 20, 30};
};

struct Scene
{
    Vec3d point;
    Vec3d normal;
    std::vector<Disc> discs;

    /// Depth of the plane at pixel coordinates.
    double depth(const Camera& camera, double x, double y) const
    {
        return dot(point - camera.world_from_camera.translation, normal) / dot(camera.ray(x, y), normal);
    }
};

/// Antialiased by 4 x 4 rays per pixel; the rest is white.
Raster8 render(const Scene& scene, const Camera& camera)
{
    constexpr int side = 4;
    const auto color_at = [&](double x, double y) -> Rgb8
    {
        const Vec3d p = camera.world_from_camera.translation + camera.ray(x, y) * scene.depth(camera, x, y);
        for (const Disc& disc : scene.discs)
            if (length(p - disc.center) <= disc.radius)
                return disc.color;
        return {255, 255, 255};
    };
    return testing::picture(camera.intrinsics.width, camera.intrinsics.height,
                            [&](int x, int y, int c)
                            {
                                double sum = 0;
                                for (int s = 0; s < side * side; ++s)
                                    sum += color_at(x + (s % side + 0.5) / side,
                                                    y + (s / side + 0.5) / side)[static_cast<std::size_t>(c)];
                                return sum / (side * side);
                            });
}

std::vector<Ellipse> found_in(const Raster8& picture)
{
    ContourCounts counts;
    return find_ellipses(picture, counts);
}

/// The ellipse whose center is next to a pixel position; null if none is within 3 px.
const Ellipse* near(const std::vector<Ellipse>& ellipses, Vec2d at)
{
    for (const Ellipse& ellipse : ellipses)
        if (length(ellipse.center - at) < 3)
            return &ellipse;
    return nullptr;
}

DepthAt depth_of(const Scene& scene, const Camera& c)
{
    return [&scene, c](Vec2d pixel) { return std::optional(scene.depth(c, pixel.x, pixel.y)); };
}
}  // namespace

TEST_CASE("what is red and what is not")
{
    // Hue in degrees: 0.08 turns are 28.8, 0.88 turns 316.8.
    const std::vector<std::pair<Rgb8, bool>> samples{{{255, 0, 0}, true},      {{255, 120, 0}, true},  // 28.2
                                                     {{255, 126, 0}, false},                           // 29.6
                                                     {{255, 0, 180}, true},                            // 317.6
                                                     {{255, 0, 188}, false},                           // 315.8
                                                     {{255, 102, 102}, true},                          // saturation 0.6
                                                     {{255, 105, 105}, false},                         //
                                                     {{153, 0, 0}, true},      {{152, 0, 0}, false},   // value 0.6
                                                     {{0, 255, 0}, false},     {{0, 0, 255}, false},   //
                                                     {{255, 255, 255}, false}, {{0, 0, 0}, false},     //
                                                     {{255, 255, 0}, false},   {{255, 0, 255}, false}};
    for (const auto& [color, is_red] : samples)
    {
        CAPTURE(int{color[0]}, int{color[1]}, int{color[2]});
        Raster8 pixel(1, 1, 3);
        std::ranges::copy(color, pixel.values.begin());
        CHECK((red_mask(pixel).values[0] == 255) == is_red);
    }
}

TEST_CASE("discs that face the camera are recovered within 5 %, at any place within a pixel")
{
    Scene scene{{0, 0, 2}, {0, 0, -1}, {}};
    const Camera c = camera(420, 300, 200);  // 1 m is 100 px
    const std::vector<double> radii_px{10.5, 12, 15.3, 20, 28.7, 40};
    double x = -1.95;
    for (const double radius : radii_px)
    {
        x += radius / 100 + 0.0537;
        scene.discs.push_back({{x, 0.0173 * radius - 0.6, 2}, radius / 100});
        scene.discs.push_back({{x + 0.0033, 0.0173 * radius + 0.35, 2}, radius / 100});
        x += radius / 100 + 0.0537;
    }
    const auto ellipses = found_in(render(scene, c));
    CHECK(ellipses.size() == scene.discs.size());
    for (const Disc& disc : scene.discs)
    {
        const Vec3d at = c.project(disc.center);
        const Ellipse* ellipse = near(ellipses, {at.x, at.y});
        CAPTURE(disc.radius);
        REQUIRE(ellipse != nullptr);
        CHECK(ellipse->radius_px() == Approx(100 * disc.radius).epsilon(0.05));
        CHECK(ellipse->stretch() < 1.04);
        CHECK(length(ellipse->center - Vec2d{at.x, at.y}) < 0.3);
    }
}

TEST_CASE("tilted discs are ellipses of known axes, and circles on their plane")
{
    for (const double tilt_deg : {30.0, 60.0})
    {
        const double tilt = tilt_deg * std::numbers::pi / 180;
        // Turned about an axis that is diagonal in the picture.
        const Vec3d along = normalized(Vec3d{1, 1, 0});
        const Vec3d normal = Vec3d{0, 0, -1} * std::cos(tilt) + normalized(Vec3d{1, -1, 0}) * std::sin(tilt);
        Scene scene{{0, 0, 4}, normal, {}};
        const Camera c = camera(400, 300, 400);
        for (const double step : {-0.8, 0.0, 0.75})
            scene.discs.push_back({Vec3d{0, 0, 4} + along * step, 0.3});
        const auto ellipses = found_in(render(scene, c));
        REQUIRE(ellipses.size() == 3);
        const Ellipse* middle = near(ellipses, {200, 150});
        REQUIRE(middle != nullptr);
        const double longer = std::max(length(middle->half_axis_1), length(middle->half_axis_2));
        const double shorter = std::min(length(middle->half_axis_1), length(middle->half_axis_2));
        CHECK(longer == Approx(30).epsilon(0.05));
        CHECK(shorter == Approx(30 * std::cos(tilt)).epsilon(0.05));
        const auto circles = circles_on_surface(ellipses, c, depth_of(scene, c));
        REQUIRE(circles.size() == 3);
        for (const Circle& circle : circles)
        {
            REQUIRE(circle.world);
            CHECK(circle.depth == Approx(4).epsilon(0.02));
            CHECK(circle.world->radius_m == Approx(0.3).epsilon(0.05));
            CHECK(circle.world->stretch < 1.05);
        }
    }
}

TEST_CASE("round patterns in the picture of a tilted wall are stretched on it")
{
    const double tilt = std::numbers::pi / 3;  // cos is one half
    const Scene wall{{0, 0, 4}, {std::sin(tilt), 0, -std::cos(tilt)}, {}};
    const Camera c = camera(200, 200, 400);
    const Ellipse round{{100, 100}, {10, 0}, {0, 10}};
    const auto circles = circles_on_surface({round}, c, depth_of(wall, c));
    REQUIRE(circles.size() == 1);
    REQUIRE(circles[0].world);
    CHECK(circles[0].world->stretch == Approx(2).epsilon(0.06));
    CHECK(circles[0].world->radius_m == Approx(0.15).epsilon(0.06));
}

TEST_CASE("an end off the surface is done without, a center is not")
{
    const Camera c = camera(100, 100, 100);
    const auto half_plane = [](Vec2d pixel) { return pixel.x < 58 ? std::optional(2.0) : std::nullopt; };
    const auto circles = circles_on_surface({{{50, 50}, {0, 10}, {10, 0}}, {{60, 50}, {0, 10}, {10, 0}}}, c, half_plane);
    REQUIRE(circles.size() == 1);
    REQUIRE(circles[0].world);
    CHECK(circles[0].world->radius_m == Approx(0.2));
    const auto strip = [](Vec2d pixel) { return std::abs(pixel.x - 50) < 5 ? std::optional(2.0) : std::nullopt; };
    const auto flat = circles_on_surface({{{50, 50}, {0, 10}, {10, 0}}}, c, strip);
    REQUIRE(flat.size() == 1);
    CHECK_FALSE(flat[0].world);
    // It counts in the picture, not in meters.
    const CircleFigures figures = circle_figures({circles, flat}, {.resamples = 2000, .seed = 1});
    CHECK(figures.circles == 2);
    CHECK(figures.circles_3d == 1);
    CHECK(figures.value.stretch == Approx(1));
}

TEST_CASE("shapes other than convex red discs of the right size are counted and left out")
{
    const Camera c = camera(400, 200, 100);
    Scene scene{{0, 0, 1}, {0, 0, -1}, {}};
    const auto disc = [&](double x_px, double y_px, double radius_px, Rgb8 color = {230, 20, 30}) {
        scene.discs.push_back({{(x_px - 200) / 100, (y_px - 100) / 100, 1}, radius_px / 100, color});
    };
    disc(50, 50, 25);                    // a disc
    disc(140, 50, 20);                   // two that overlap: waisted
    disc(172, 50, 20);                   //
    disc(250, 50, 6);                    // too small
    disc(320, 50, 25, {20, 30, 230});    // blue
    disc(60, 140, 18, {250, 250, 250});  // a ring: its hole is white
    disc(60, 140, 30);
    ContourCounts counts;
    const Raster8 picture = render(scene, c);
    const auto paper = find_ellipses(picture, counts);
    CHECK(paper.size() == 2);
    CHECK(counts.contours == 4);
    CHECK(counts.not_convex == 1);
    CHECK(counts.out_of_range == 1);
    CHECK(near(paper, {50, 50}) != nullptr);
    CHECK(near(paper, {60, 140}) != nullptr);
}

namespace
{
/// A wall at z = 2 m with three discs, seen by cameras of a narrow, high picture from 2 m and from 1 m.
struct Recording : JudgedViews
{
    explicit Recording(int height)
    {
        const Scene scene{{0, 0, 2}, {0, 0, -1}, {{{0, -0.5, 2}, 0.1}, {{0.02, 0, 2}, 0.12}, {{0, 0.4, 2}, 0.08}}};
        for (const double z : {0.0, 1.0})
        {
            const Frame frame = testing::frame(z == 0 ? "far" : "near", camera(100, height, 300, {0, 0, z}));
            add(frame, render(scene, frame.color));
        }
    }

    std::string judge(testing::TestRun& run, int every = 1) const
    {
        return JudgedViews::judge("evaluate.circles", Value::Map{{"every", every}},
                                  {{"views", views}, {"frames", frames}, {"mesh", std::make_shared<Mesh>(testing::wall(9))}},
                                  run);
    }
};
}  // namespace

TEST_CASE_METHOD(testing::StageTest, "the stage measures the circles of renders")
{
    const Recording recording(784);
    const std::string text = recording.judge(run);
    const Value figures = parse_json(text);
    CHECK(figures.at("circles").as_int() == 6);
    CHECK(figures.at("circles_3d").as_int() == 6);
    CHECK(figures.at("stretch").at("value").as_double() == Approx(1).margin(0.03));
    // Depths 2 and 1 m, radii 15, 18, 12 and 30, 36, 24 px; the same sizes in meters at both.
    CHECK(figures.at("corr_2d").at("value").as_double() == Approx(-0.8885).margin(0.02));
    CHECK(figures.at("corr_3d").at("value").as_double() == Approx(0).margin(0.05));
    CHECK(figures.at("picture_circles").as_list().size() == 2);
    CHECK(figures.at("picture_circles").as_list()[1].at("circles").as_list().size() == 3);
    CHECK(run.reported.at("corr_2d") == figures.at("corr_2d"));
    CHECK(std::ranges::any_of(run.messages, [](const auto& line) { return line.starts_with("Corr2D -0.8"); }));

    const Value fewer = parse_json(recording.judge(run, 2));
    CHECK(fewer.at("pictures").as_int() == 1);
    CHECK(fewer.at("circles").as_int() == 3);
    testing::TestRun one(1);
    CHECK(recording.judge(one) == text);
}

TEST_CASE_METHOD(testing::StageTest, "the stage refuses low pictures and stops when asked")
{
    const Recording low(300);
    CHECK_THROWS_WITH(low.judge(run), Catch::Contains("is 300 px high") && Catch::Contains("height_px: 784"));
    // On one thread: another one would go on to the second picture and refuse it.
    testing::TestRun stopped(1);
    stopped.cancel_after(1);
    CHECK_THROWS_AS(low.judge(stopped), Canceled);
}
