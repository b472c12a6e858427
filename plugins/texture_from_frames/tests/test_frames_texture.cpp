#include "catch.h"
#include "painted_wall.h"

#include <fresco/error.h>
#include <fresco/images/push_pull.h>
#include <fresco/testing.h>

using namespace painted_wall;

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

TEST_CASE("the streamed texture is the one that sorting every sample gives, for any number of threads")
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
    for (const int threads : {2, 3, 8})
    {
        testing::TestRun run(threads);
        const auto again = texture_of(views, rules, run);
        CHECK((again.picture == made.picture));
        CHECK((again.seen == made.seen));
        CHECK(again.gains == made.gains);
        CHECK(again.rejected_samples == made.rejected_samples);
    }
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

TEST_CASE("views that see nothing are refused, and a stop is heeded")
{
    testing::TestRun run;
    View blind = view_of(camera_at(1, 1, 2), 30, smooth_paint);
    blind.map.valid = Raster8(40, 30);
    CHECK_THROWS_WITH(texture_of({blind}, rules_of(16), run), Catch::Contains("no view shows a texel"));
    run.cancel_after(3);
    CHECK_THROWS_AS(texture_of(five_views(30), rules_of(16), run), Canceled);
}
