#include "catch.h"
#include "pictures.h"
#include "repeats.h"
#include <fresco/testing_scenes.h>

#include <fresco/images/stroke_width.h>
#include <fresco/random.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace fresco;

namespace
{

constexpr int per_stroke = 4;

/// A wall of `strokes` x 4 strokes, points a quarter of a stroke apart, from places (in strokes) by place (in points).
std::vector<CopiedPoint> wall(int strokes, const std::function<Vec2f(float, float)>& place, bool is_motif = true)
{
    std::vector<CopiedPoint> points;
    for (int y = 0; y < 4 * per_stroke; ++y)
        for (int x = 0; x < strokes * per_stroke; ++x)
        {
            const auto u = static_cast<float>(x);
            const auto v = static_cast<float>(y);
            points.push_back({Vec3f{u, v, 0} * (1.0F / per_stroke), place(u, v) * (1.0F / per_stroke), 1, is_motif});
        }
    return points;
}

/// Copies of one part of the picture side by side, so many points wide each.
Vec2f tiled(float x, float y, int width)
{
    return {100 + std::fmod(x, static_cast<float>(width)), 50 + y};
}

/// Every point against every other one, in double precision.
Repeats plain_repeats(const std::vector<CopiedPoint>& points)
{
    double repeated = 0;
    double woven = 0;
    for (const CopiedPoint& p : points)
    {
        bool is_repeated = false;
        std::vector<Vec3d> steps;
        for (const CopiedPoint& q : points)
        {
            const Vec3d step = (vec_cast<double>(q.at) - vec_cast<double>(p.at)) * static_cast<double>(p.scale);
            const double away = length(step);
            const double apart = static_cast<double>(length(q.place - p.place));
            if (q.scale != p.scale)
                continue;
            is_repeated = is_repeated || (p.is_motif && away > 1.5 && away < 10 && apart < 0.5);
            if (away >= 0.25 && away <= 2.5 && apart <= std::min(0.2, away / 4))
                steps.push_back(step);
        }
        repeated += is_repeated ? 1 : 0;
        const auto is_opposite = [](Vec3d a, Vec3d b) { return length(a + b) < 0.2 * (length(a) + length(b)); };
        woven += std::ranges::any_of(steps, [&](Vec3d a)
                                     { return std::ranges::any_of(steps, [&](Vec3d b) { return is_opposite(a, b); }); })
                     ? 1
                     : 0;
    }
    const auto count = static_cast<double>(points.size());
    return {repeated / count, woven / count};
}

void check(const std::vector<CopiedPoint>& points, double repeated, double woven)
{
    for (const int threads : {1, 3})
    {
        const Repeats found = repeats(points, testing::TestRun(threads));
        CHECK(found.repeats == Approx(repeated).margin(1e-12));
        CHECK(found.weave == Approx(woven).margin(1e-12));
    }
}

}  // namespace

TEST_CASE("one coherent copy repeats nothing, however it is turned")
{
    for (const float angle : {0.0F, 0.7F, 2.0F})
        check(wall(15,
                   [angle](float x, float y) {
                       return Vec2f{100 + std::cos(angle) * x - std::sin(angle) * y,
                                    100 + std::sin(angle) * x + std::cos(angle) * y};
                   }),
              0, 0);
}

TEST_CASE("copies side by side are repeats of a motif, not of a plain place, and close ones a weave")
{
    // Six copies, each three strokes wide: too far apart for a weave.
    const auto wide = [](float x, float y) { return tiled(x, y, 12); };
    check(wall(18, wide), 1, 0);
    check(wall(18, wide, false), 0, 0);
    // One and two of them.
    check(wall(3, wide), 0, 0);
    check(wall(6, wide), 1, 0);
    // Eight copies of a stroke and a half: all but the outermost have one to either side.
    const auto narrow = [](float x, float y) { return tiled(x, y, 6); };
    check(wall(12, narrow), 1, 6.0 / 8);
    check(wall(12, narrow, false), 0, 6.0 / 8);
    // Farther apart than in sight: 12 strokes.
    auto far = wall(3, wide);
    for (CopiedPoint point : wall(3, wide))
    {
        point.at.x += 12;
        far.push_back(point);
    }
    check(far, 0, 0);
    // Of strokes twice as wide, the same copies are 6 strokes apart.
    for (CopiedPoint& point : far)
        point.scale = 0.5F;
    check(far, 1, 0);
    // Another scale is another motif.
    for (std::size_t i = 0; i < far.size() / 2; ++i)
        far[i].scale = 1;
    check(far, 0, 0);
}

TEST_CASE("the figures are those of a plain search in any order of the points")
{
    Random random(4);
    const auto within = [&](double side) { return static_cast<float>(side * random.uniform()); };
    const auto whole = [&](int count) { return static_cast<float>(random.below(count)); };
    const auto expected_of = [&](int places)
    {
        std::vector<CopiedPoint> points(1800);
        for (CopiedPoint& point : points)
            point = {{whole(24) / 2 - 6 + within(0.02), whole(16) / 2, whole(2) * 3},
                     {within(places), within(places)},
                     1 + whole(2),
                     random.below(2) == 0};
        const Repeats expected = plain_repeats(points);
        check(points, expected.repeats, expected.weave);
        std::ranges::reverse(points);
        check(points, expected.repeats, expected.weave);
        return expected;
    };
    const Repeats rare = expected_of(24);
    CHECK(rare.repeats > 0.1);
    CHECK(rare.repeats < 0.45);
    const Repeats frequent = expected_of(2);
    CHECK(frequent.weave > 0.02);
    CHECK(frequent.weave < 0.8);
}

TEST_CASE("a map's points are measured in strokes, and motifs are told from plain places")
{
    // Two charts, a meter and 76.8 texels a side each.
    const Mesh mesh = testing::two_chart_wall();
    Raster8 picture = pictures::painting(160, 160, 3);
    for (int y = 0; y < 160; ++y)
        for (int x = 0; x < 64; ++x)
            pictures::set_color(picture, x, y, {0.5F, 0.5F, 0.5F});
    const testing::TestRun run(2);
    const double stroke_px = stroke_width_px(picture, run);
    const auto map_of = [](const std::function<Vec2f(float, float)>& place)
    {
        SourceMap map;
        map.picture_width = map.picture_height = 160;
        map.pixels_per_texel = 1;
        map.clear(256);
        for (int y = 0; y < 256; ++y)
            for (int x = 0; x < 256; ++x)
                map.set_place(x, y, {place(static_cast<float>(x), static_cast<float>(y)), 0});
        return map;
    };
    const auto points = copied_points(map_of([](float, float) { return Vec2f{120, 90}; }), mesh, picture, run);
    REQUIRE(points.size() > 100);
    const auto by_x = [](const CopiedPoint& p) { return p.at.x; };
    const auto [low, high] = std::ranges::minmax(points, {}, by_x);
    CHECK(double{high.at.x - low.at.x} == Approx(2 * 76.8 / stroke_px).epsilon(0.05));
    CHECK(points.front().place.x == Approx(120 / stroke_px).epsilon(1e-3));

    const auto shares = [&](float left)
    {
        return repeats(copied_points(map_of(
                                         [left](float x, float y) {
                                             return Vec2f{left + std::fmod(x, 25.0F), 60 + std::fmod(y, 25.0F)};
                                         }),
                                     mesh, picture, run),
                       run);
    };
    CHECK(shares(20).repeats == 0);  // Gray.
    CHECK(shares(100).repeats > 0.2);
    SourceMap other = map_of([](float, float) { return Vec2f{1, 1}; });
    other.picture_width = 99;
    CHECK_THROWS_WITH(copied_points(other, mesh, picture, run), Catch::Contains("99 x 160") && Catch::Contains("160 x 160"));
}
