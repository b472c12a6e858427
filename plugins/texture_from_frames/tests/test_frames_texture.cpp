#include "catch.h"
#include "frames_texture.h"
#include "painted_wall.h"

#include <fresco/error.h>
#include <fresco/images/filters.h>
#include <fresco/random.h>
#include <fresco/testing.h>

#include <algorithm>
#include <cmath>

using namespace painted_wall;
using namespace fresco;
using namespace fresco::from_frames;

namespace
{

TextureRules rules_of(int size)
{
    return {.size_px = size,
            .views_count = 16,
            .solve_exposure = true,
            .sharpness_power = 2,
            .weights = {.edge_margin_px = 2, .sensor_tolerance_m = 0.1},
            .blend = {.reject_outliers = true}};
}

std::vector<View> five_views(int map_height, const Paint& paint = smooth_paint)
{
    std::vector<View> views;
    for (const Camera& camera : five_cameras())
        views.push_back(view_of(camera, map_height, paint));
    return views;
}

/// Everything at once, kept in memory and sorted: what the streaming, blocked and threaded way must give.
RasterF slow_texture(const std::vector<View>& views, const std::vector<Gain>& gains, const std::vector<double>& sharpness,
                     const TextureRules& rules, Raster8& seen)
{
    const auto texels = static_cast<std::size_t>(rules.size_px) * static_cast<std::size_t>(rules.size_px);
    std::vector<std::vector<KeptSample>> all(texels);
    for (std::size_t v = 0; v < views.size(); ++v)
    {
        const View& view = views[v];
        const PixelLinks links(view.map, view.camera);
        const auto weights = view_weights(view.map, links, view.camera, view.measured, rules.size_px, rules.weights);
        for (const auto& block :
             gather(view.map, links, weights.weight, PicturePyramid(view.picture), {rules.size_px, rules.size_px, false}))
            for (const auto& s : block)
                all[s.texel].push_back({s.weight * static_cast<float>(sharpness[v]),
                                        {s.rgb[0] * static_cast<float>(gains[v][0]), s.rgb[1] * static_cast<float>(gains[v][1]),
                                         s.rgb[2] * static_cast<float>(gains[v][2])}});
    }
    RasterF picture(rules.size_px, rules.size_px, 3);
    seen = Raster8(rules.size_px, rules.size_px);
    for (std::size_t i = 0; i < texels; ++i)
    {
        if (all[i].empty())
            continue;
        std::stable_sort(all[i].begin(), all[i].end(), [](const auto& a, const auto& b) { return a.heavier_than(b); });
        all[i].resize(static_cast<std::size_t>(rules.views_count) + 1);
        const auto color = blended(all[i], rules.blend).rgb;
        std::copy(color.begin(), color.end(), picture.values.begin() + static_cast<std::ptrdiff_t>(3 * i));
        seen.values[i] = 1;
    }
    push_pull(picture, seen);
    return picture;
}

}  // namespace

TEST_CASE("a painted wall's texture is found again")
{
    testing::TestRun run;
    const auto made = texture_of(five_views(60), rules_of(64), run);
    CHECK(largest_error(made, smooth_paint) < 0.012);
    CHECK(made.gains.size() == 5);
    CHECK(made.pixels > 5000);
    CHECK(1000 * made.rejected_samples < made.blended_samples);  // At the wall's rim, where pixels show black beside it.
    CHECK(made.occluded_pixels == 0);
    for (int i = 0; i < 64 * 64; ++i)
        REQUIRE(made.seen.values[static_cast<std::size_t>(i)] == 1);
}

TEST_CASE("a texture finer than the maps has no holes and the pictures' own detail")
{
    // Stripes of 1/40 of the wall: 1.2 pixels of the map, 4.8 of the picture, 6.4 texels.
    const Paint stripes = [](double u, double v)
    {
        const auto value = static_cast<float>(0.5 + 0.4 * std::sin(80 * 3.14159265 * u));
        return Vec3f{value, value, static_cast<float>(0.2 + 0.5 * v)};
    };
    std::vector<View> views;
    for (const auto& [x, y] : {std::pair{1.0, 1.0}, {0.9, 1.1}})
        views.push_back(view_of(camera_at(x, y, 2, 0, 640, 480), 40, stripes));
    testing::TestRun run;
    const auto made = texture_of(views, rules_of(256), run);
    CHECK(largest_error(made, stripes, 24) < 0.06);
    for (int y = 24; y < 232; ++y)
        for (int x = 24; x < 232; ++x)
            REQUIRE(made.seen.at(x, y) == 1);
}

TEST_CASE("exposures that pictures were given are solved")
{
    const auto cameras = five_cameras();
    const std::vector<Vec3f> factors{
        {1.2F, 0.9F, 1}, {0.85F, 1.1F, 1}, {1, 1, 1.1F}, {1 / 1.2F, 1 / 0.9F, 1 / 1.1F}, {1 / 0.85F, 1 / 1.1F, 1}};
    std::vector<View> views;
    for (std::size_t i = 0; i < cameras.size(); ++i)
        views.push_back(view_of(cameras[i], 60, smooth_paint, factors[i]));
    testing::TestRun run;
    TextureRules rules = rules_of(64);
    const auto made = texture_of(views, rules, run);
    for (std::size_t i = 0; i < cameras.size(); ++i)
    {
        CAPTURE(i);
        CHECK(made.gains[i][0] * static_cast<double>(factors[i].x) == Approx(1).epsilon(0.01));
        CHECK(made.gains[i][1] * static_cast<double>(factors[i].y) == Approx(1).epsilon(0.01));
        CHECK(made.gains[i][2] * static_cast<double>(factors[i].z) == Approx(1).epsilon(0.01));
    }
    CHECK(largest_error(made, smooth_paint) < 0.015);
    rules.solve_exposure = false;
    const auto raw = texture_of(views, rules, run);
    CHECK(largest_error(raw, smooth_paint) > 0.03);
    CHECK(raw.gains[0] == Gain{1, 1, 1});
}

TEST_CASE("detail in only one of five pictures does not enter the texture")
{
    const auto clean = five_views(60);
    auto views = clean;
    for (int y = 40; y < 80; ++y)
        for (int x = 60; x < 100; ++x)
            for (int c = 0; c < 3; ++c)
                views[2].picture.at(x, y, c) = c == 1 ? 255 : 0;
    testing::TestRun run;
    TextureRules rules = rules_of(64);
    rules.sharpness_power = 0;  // The block is sharp.
    const auto expected = texture_of(clean, rules, run);
    const auto made = texture_of(views, rules, run);
    CHECK(made.rejected_samples > 300);
    float largest = 0;
    double sum = 0;
    for (std::size_t i = 0; i < made.picture.values.size(); ++i)
    {
        const float difference = std::abs(made.picture.values[i] - expected.picture.values[i]);
        largest = std::max(largest, difference);
        sum += static_cast<double>(difference);
    }
    CHECK(largest < 0.015F);  // At the block's rim, where pixels of it and of the wall mix.
    CHECK(sum / static_cast<double>(made.picture.values.size()) < 5e-4);
    rules.blend.reject_outliers = false;
    CHECK(largest_error(texture_of(views, rules, run), smooth_paint) > 0.05);
}

TEST_CASE("color does not bleed over a depth step when a picture is out of place")
{
    // A red board 30 cm in front of the wall hides the right half of view 0, whose picture lies two pixels too far left. Of the
    // wall, only the left half is judged.
    const Paint gray = [](double, double) { return Vec3f{0.25F, 0.25F, 0.25F}; };
    View shifted = view_of(camera_at(1, 1, 2.6), 120, gray);
    for (int y = 0; y < 120; ++y)
        for (int x = 78; x < 160; ++x)
        {
            shifted.picture.at(x, y, 0) = 200;
            if (x < 80)
                continue;
            shifted.map.depth.at(x, y) = 2.3F;
            // Its own chart, in the texture's other half.
            shifted.map.uv.at(x, y, 0) = 0.55F + 0.005F * static_cast<float>(x - 80);
            shifted.map.uv.at(x, y, 1) = 0.9F - 0.005F * static_cast<float>(y);
        }
    const View other = view_of(camera_at(0.7, 1, 2.6), 120, gray);
    const auto reddest = [&](const std::vector<View>& views, double margin)
    {
        TextureRules rules = rules_of(64);
        rules.weights.edge_margin_px = margin;
        rules.solve_exposure = false;
        rules.sharpness_power = 0;
        rules.blend.reject_outliers = false;
        testing::TestRun run;
        const auto made = texture_of(views, rules, run);
        float most = 0;
        for (int y = 20; y < 44; ++y)
            for (int x = 8; x < 32; ++x)
                most = std::max(most, made.picture.at(x, y, 0));
        return most;
    };
    CHECK(reddest({shifted}, 0) > 0.75F);
    CHECK(reddest({shifted, other}, 0) > 0.4F);
    CHECK(reddest({shifted, other}, 3) < 0.26F);
    // What no other view shows is taken even so.
    CHECK(reddest({shifted}, 3) > 0.75F);
}

TEST_CASE("what the depth camera saw in front of the mesh is left out")
{
    auto views = five_views(60);
    for (auto& view : views)
    {
        view.measured = view.map.depth;
        for (std::size_t i = 0; i < view.measured.values.size(); i += 5)
            view.measured.values[i] = 0;  // Not measured: kept.
    }
    // Somebody in all views but one, where the wall's middle is.
    std::size_t hidden = 0;
    for (std::size_t v = 1; v < views.size(); ++v)
        for (int y = 24; y < 36; ++y)
            for (int x = 34; x < 46; ++x)
            {
                for (int i = 0; i < 4; ++i)
                    for (int c = 0; c < 3; ++c)
                        views[v].picture.at(2 * x + i % 2, 2 * y + i / 2, c) = 255;
                views[v].measured.at(x, y) = 1.5F;
                ++hidden;
            }
    testing::TestRun run;
    TextureRules rules = rules_of(64);
    rules.solve_exposure = false;
    const auto made = texture_of(views, rules, run);
    CHECK(made.occluded_pixels == hidden);
    CHECK(largest_error(made, smooth_paint) < 0.02);
    for (auto& view : views)
        view.measured = {};
    CHECK(largest_error(texture_of(views, rules, run), smooth_paint) > 0.2);
}

TEST_CASE("the streamed texture is the one that sorting every sample gives")
{
    auto views = five_views(45);
    for (const double x : {0.3, 0.6, 1.4})
        views.push_back(view_of(camera_at(x, 1.2, 1.2, 0.1), 45, smooth_paint, {1.1F, 1, 0.95F}));
    for (int y = 30; y < 60; ++y)
        for (int x = 20; x < 60; ++x)
            views[6].picture.at(x, y, 0) = 10;
    TextureRules rules = rules_of(70);  // No whole number of blocks.
    rules.views_count = 3;
    testing::TestRun one(1);
    const auto made = texture_of(views, rules, one);
    Raster8 seen;
    const RasterF slow = slow_texture(views, made.gains, made.sharpness, rules, seen);
    CHECK((made.picture == slow));
    CHECK((made.seen == seen));
}

TEST_CASE("unseen texels continue the seen ones")
{
    // The view sees only the left part of the wall.
    const auto made = [&]
    {
        testing::TestRun run;
        return texture_of({view_of(camera_at(0.3, 1, 1), 60, smooth_paint)}, rules_of(64), run);
    }();
    CHECK(made.seen.at(10, 32) == 1);
    CHECK(made.seen.at(60, 32) == 0);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            CHECK(made.picture.at(x, y, 1) > 0.1F);
}

TEST_CASE("blurred pictures count less than their neighbors")
{
    const std::vector<std::string> walk(7, "walk");
    const auto factors = sharpness_factors({100, 100, 25, 100, 100, 400, 100}, walk, 1);
    CHECK(factors == std::vector<double>{1, 1, 0.25, 1, 1, 4, 1});
    CHECK(sharpness_factors({100, 100, 25, 100, 100, 400, 100}, walk, 0.5)[2] == Approx(0.5));
    CHECK(sharpness_factors({100, 100, 25, 100, 100, 400, 100}, walk, 2)[2] == 0.1);
    CHECK(sharpness_factors({1, 100, 100}, {"a", "b", "b"}, 1) == std::vector<double>{1, 1, 1});
    CHECK(sharpness_factors({0, 0, 0}, {"a", "a", "a"}, 1) == std::vector<double>{1, 1, 1});
    // Not compared with what was recorded long before.
    std::vector<double> recorded(20, 10.0);
    std::fill(recorded.begin() + 10, recorded.end(), 90.0);
    CHECK(sharpness_factors(recorded, std::vector<std::string>(20, "walk"), 1)[19] == 1);
}

TEST_CASE("views that see nothing are refused")
{
    testing::TestRun run;
    View blind = view_of(camera_at(1, 1, 2), 30, smooth_paint);
    blind.map.valid = Raster8(40, 30);
    CHECK_THROWS_WITH(texture_of({blind}, rules_of(16), run), Catch::Contains("no view shows a texel"));
}

namespace
{

KeptSample sample(float weight, float value)
{
    return {weight, {value, value, value}};
}

constexpr BlendRules keep_all{false};
constexpr BlendRules reject{true};

}  // namespace

TEST_CASE("samples are kept in eight bytes")
{
    static_assert(sizeof(KeptSample) == 8);
    CHECK(KeptSample().empty());
    const KeptSample kept(0.3F, {0.25F, 1.5F, 3.0F});
    CHECK(kept.weight() <= 0.3F);
    CHECK(kept.weight() == Approx(0.3).epsilon(1 / 128.0));
    CHECK(kept.rgb()[0] == Approx(0.25).margin(2e-5));
    CHECK(kept.rgb()[1] == Approx(1.5).margin(2e-5));
    CHECK(kept.rgb()[2] == Approx(2).margin(1e-4));
    CHECK(KeptSample(1e-4F, {}).heavier_than(KeptSample(0.9e-4F, {})));
}

TEST_CASE("colors are weighted means, from which the last of all places is taken off")
{
    const std::vector<KeptSample> two{sample(0.75F, 0.2F), sample(0.25F, 0.6F), {}};
    CHECK(blended(two, keep_all).rgb[1] == Approx(0.3).margin(1e-4));
    CHECK(blended(two, keep_all).used == 2);
    // 1 - 0.25 and 0.5 - 0.25 of the weight remain.
    const std::vector<KeptSample> full{sample(1, 0.2F), sample(0.5F, 0.6F), sample(0.25F, 0.9F)};
    CHECK(blended(full, keep_all).rgb[0] == Approx((0.75 * 0.2 + 0.25 * 0.6) / 1).margin(1e-4));
    CHECK(blended(full, keep_all).used == 2);
    const std::vector<KeptSample> equal{sample(1, 0.2F), sample(1, 0.6F), sample(1, 0.7F)};
    CHECK(blended(equal, keep_all).rgb[0] == Approx(0.5).margin(1e-4));
    const std::vector<KeptSample> bright{sample(1, 1.6F), {}};
    CHECK(blended(bright, keep_all).rgb[2] == 1);
}

TEST_CASE("a color fades in as its view becomes one of the best")
{
    float before = 0.2F;
    for (float weight = 0.26F; weight < 1; weight += 0.02F)
    {
        const std::vector<KeptSample> samples{sample(1, 0.2F), sample(weight, 0.3F), sample(0.25F, 0.9F)};
        const float value = blended(samples, keep_all).rgb[0];
        CHECK(value > before);
        CHECK(value < before + 0.02F);
        before = value;
    }
}

TEST_CASE("what disagrees with most of the weight does not count")
{
    std::vector<KeptSample> samples{sample(1, 0.95F), sample(0.9F, 0.41F), sample(0.9F, 0.4F), sample(0.9F, 0.39F), {}};
    const Blend blend = blended(samples, reject);
    CHECK(blend.rgb[0] == Approx(0.4).margin(1e-3));
    CHECK(blend.rejected == 1);
    CHECK(blend.used == 4);
    CHECK(blended(samples, keep_all).rgb[0] > 0.5F);
    CHECK(blended(samples, keep_all).rejected == 0);
    // One channel is enough to disagree.
    samples[0] = {1, {0.4F, 0.4F, 0.9F}};
    CHECK(blended(samples, reject).rgb[2] == Approx(0.4).margin(1e-3));
    // Small differences are averaged: 0.44 and 0.36 are as far from the middle on both sides.
    samples = {sample(1, 0.44F), sample(1, 0.36F), {}};
    CHECK(blended(samples, reject).rgb[0] == Approx(0.4).margin(1e-3));
    CHECK(blended(samples, reject).rejected == 0);
}

TEST_CASE("without outliers rejecting changes little")
{
    Random random(7);
    for (int round = 0; round < 200; ++round)
    {
        std::vector<KeptSample> samples;
        for (int i = 0; i < 9; ++i)
            samples.push_back(sample(static_cast<float>(1 - 0.1 * i), static_cast<float>(0.5 + 0.02 * random.normal())));
        CHECK(blended(samples, reject).rgb[0] == Approx(blended(samples, keep_all).rgb[0]).margin(0.01));
        CHECK(blended(samples, reject).rejected == 0);
    }
}

TEST_CASE("the best samples are those that sorting all of them finds")
{
    constexpr std::size_t texels = 50;
    constexpr std::size_t places = 4;
    Random random(5);
    BestSamples best(texels, places);
    std::vector<std::vector<KeptSample>> all(texels);
    for (int view = 0; view < 30; ++view)
    {
        const auto factor = static_cast<float>(0.5 + random.uniform());
        const std::array<float, 3> gain{1.2F, 0.9F, 1.0F};
        std::vector<TexelSample> samples;
        for (std::uint32_t texel = 0; texel < texels; ++texel)
            if (random.below(3) == 0)
            {
                const auto value = static_cast<float>(0.8 * random.uniform());
                samples.push_back({texel, static_cast<float>(random.below(8) + 1), {value, value, value}});
                all[texel].push_back({samples.back().weight * factor, {value * 1.2F, value * 0.9F, value}});
            }
        best.add(samples, factor, gain);
    }
    for (std::size_t texel = 0; texel < texels; ++texel)
    {
        std::stable_sort(all[texel].begin(), all[texel].end(), [](const auto& a, const auto& b) { return a.heavier_than(b); });
        all[texel].resize(places);
        const auto found = best.of(texel);
        REQUIRE(found.size() == places);
        for (std::size_t i = 0; i < places; ++i)
        {
            CHECK(found[i].weight() == all[texel][i].weight());
            CHECK(found[i].rgb() == all[texel][i].rgb());
        }
    }
}

TEST_CASE("what is saturated stays white and gives way to what is not")
{
    BestSamples best(2, 3);
    const std::array<float, 3> gain{0.8F, 0.95F, 0.7F};
    best.add(std::vector<TexelSample>{{0, 1, {1, 1, 1}}, {1, 1, {1, 1, 1}}}, 1, gain);
    best.add(std::vector<TexelSample>{{0, 0.5F, {0.85F, 0.5F, 0.4F}}}, 1, std::array<float, 3>{1.2F, 1.2F, 1.2F});
    CHECK(best.of(1)[0].rgb() == std::array<float, 3>{1, 1, 1});
    CHECK(best.of(1)[0].weight() == Approx(0.3).epsilon(0.01));
    CHECK(best.of(0)[0].rgb()[0] == Approx(1.02).margin(1e-4));
    CHECK(best.of(0)[0].rgb()[2] == Approx(0.48).margin(1e-4));
    CHECK(best.of(0)[1].rgb()[0] == 1);
    // Half way: 0.95 is at the middle of the step, so half of the gain and half of white.
    BestSamples other(1, 2);
    other.add(std::vector<TexelSample>{{0, 1, {0.95F, 0.5F, 0}}}, 1, std::array<float, 3>{0.8F, 0.8F, 0.8F});
    CHECK(other.of(0)[0].rgb()[0] == Approx(0.95 * 0.9).margin(1e-4));
    CHECK(other.of(0)[0].rgb()[1] == Approx(0.5 * 0.9).margin(1e-4));
    CHECK(other.of(0)[0].weight() == Approx(0.65).epsilon(0.01));
    BestSamples as_it_is(1, 2);
    as_it_is.add(std::vector<TexelSample>{{0, 1, {1, 1, 1}}}, 1, std::nullopt);
    CHECK(as_it_is.of(0)[0].weight() == 1);
}

namespace
{

struct World
{
    std::vector<std::vector<CellColor>> views;
    std::vector<Gain> brightness;  ///< What each view's picture was multiplied by.
};

/// Views along a wall of 400 cells: view v sees cells 40 v to 40 v + 120, multiplied by factors whose logarithms sum to 0.
World wall(std::size_t count, double noise)
{
    Random random(17);
    World world;
    world.views.resize(count);
    std::vector<Gain> colors(400);
    for (auto& color : colors)
        for (auto& value : color)
            value = 0.2 + 0.5 * random.uniform();
    for (std::size_t v = 0; v < count; ++v)
    {
        const double sign = v % 2 == 0 ? 1 : -1;
        const double part = v + 1 == count && count % 2 == 1 ? 0 : 0.05 * static_cast<double>(v / 2 + 1);
        world.brightness.push_back({std::exp(sign * part), std::exp(-sign * part / 2), std::exp(sign * part / 4)});
        for (std::uint32_t cell = 40 * static_cast<std::uint32_t>(v); cell < 40 * v + 120; ++cell)
        {
            CellColor seen{cell, 1, {}};
            for (std::size_t c = 0; c < 3; ++c)
                seen.log_rgb[c] =
                    static_cast<float>(std::log(colors[cell][c] * world.brightness[v][c]) + noise * random.normal());
            world.views[v].push_back(seen);
        }
    }
    return world;
}

void check_gains(const World& world, double tolerance)
{
    const auto gains = exposure_gains(world.views, 400, Progress());
    for (std::size_t v = 0; v < world.views.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c)
        {
            CAPTURE(v, c);
            CHECK(gains[v][c] * world.brightness[v][c] == Approx(1).epsilon(tolerance));
        }
}

}  // namespace

TEST_CASE("factors that pictures were multiplied by are found, to 1 %")
{
    check_gains(wall(7, 0), 0.002);
    check_gains(wall(7, 0.03), 0.01);
}

TEST_CASE("highlights and what stands in front do not spoil the factors")
{
    World world = wall(7, 0.01);
    for (std::size_t v = 0; v < 7; v += 2)
        for (std::size_t i = 0; i < 30; ++i)
            world.views[v][i].log_rgb = {-0.1F, -0.1F, -0.1F};
    check_gains(world, 0.01);
}

TEST_CASE("views that share nothing keep their exposure, and every group keeps its mean")
{
    World world = wall(4, 0);
    for (auto& view : world.views)  // Views 0 and 1 see each other; 2 and 3 see cells far away.
        for (auto& color : view)
            if (&view == &world.views[2] || &view == &world.views[3])
                color.cell += 150;
    world.views.push_back({{5, 1, {-1, -1, -1}}});
    world.views.push_back({});
    world.views.back().push_back({399, 1, {-2, -2, -2}});
    world.views[4][0].cell = 398;
    const auto gains = exposure_gains(world.views, 400, Progress());
    for (std::size_t c = 0; c < 3; ++c)
    {
        CHECK(gains[4][c] == Approx(1));
        CHECK(gains[5][c] == Approx(1));
        CHECK(std::log(gains[0][c]) + std::log(gains[1][c]) == Approx(0).margin(1e-9));
        CHECK(std::log(gains[2][c]) + std::log(gains[3][c]) == Approx(0).margin(1e-9));
        CHECK(gains[0][c] / gains[1][c] == Approx(world.brightness[1][c] / world.brightness[0][c]).epsilon(0.002));
    }
}

TEST_CASE("cells that are nearly black or saturated say nothing, and all views choose the same of too many")
{
    SampleBlocks samples(2);
    samples[1].push_back({9, 0.5F, {0.5F, 0.25F, 0.1F}});
    samples[0].push_back({3, 1, {0.5F, 0.5F, 0.02F}});
    samples[0].push_back({4, 1, {0.5F, 0.99F, 0.5F}});
    const auto colors = cell_colors(samples);
    REQUIRE(colors.size() == 1);
    CHECK(colors[0].cell == 9);
    CHECK(colors[0].weight == 0.5F);
    CHECK(colors[0].log_rgb[1] == Approx(std::log(0.25)));

    SampleBlocks many(1);
    SampleBlocks half(1);
    for (std::uint32_t cell = 0; cell < 20000; ++cell)
    {
        many[0].push_back({cell, 1, {0.5F, 0.5F, 0.5F}});
        if (cell < 10000)
            half[0].push_back(many[0].back());
    }
    const auto of_many = cell_colors(many);
    const auto of_half = cell_colors(half);
    CHECK(of_many.size() == 4096);
    CHECK(of_half.size() == 4096);
    std::size_t shared = 0;
    for (const auto& color : of_many)
        shared += std::any_of(of_half.begin(), of_half.end(), [&](const CellColor& other) { return other.cell == color.cell; });
    const auto below = std::count_if(of_many.begin(), of_many.end(), [](const CellColor& c) { return c.cell < 10000; });
    CHECK(static_cast<std::ptrdiff_t>(shared) == below);
    CHECK(below > 1800);
    CHECK(below < 2300);
    CHECK(std::is_sorted(of_many.begin(), of_many.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; }));
}
