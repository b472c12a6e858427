#include "catch.h"
#include "frames_texture.h"
#include "painted_wall.h"

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
    return {.size_px = size, .views_count = 16};
}

/// Everything at once, kept in memory and sorted: what the streaming, blocked and threaded way must give.
RasterF slow_texture(const std::vector<View>& views, const std::vector<Gains>& gains, const std::vector<double>& sharpness,
                     const TextureRules& rules, Raster8& seen)
{
    const auto texels = static_cast<std::size_t>(rules.size_px) * static_cast<std::size_t>(rules.size_px);
    std::vector<std::vector<KeptSample>> all(texels);
    for (std::size_t v = 0; v < views.size(); ++v)
    {
        const View& view = views[v];
        const PixelLinks links(view.map, view.camera);
        const auto weights = view_weights(view.map, links, view.camera, rejected_pixels(view.map, view.measured), rules.size_px);
        const PicturePyramid picture(view.picture);
        gather(view.map, links, weights.weight, {rules.size_px, rules.size_px, false},
               [&](std::size_t, std::span<const DrawnSample> samples)
               {
                   for (const DrawnSample& s : samples)
                       all[s.texel].push_back({s.weight * static_cast<float>(sharpness[v]),
                                               picture.at(s.at, s.covered) * four_between(gains[v], s.at[0], s.at[1])});
               });
    }
    RasterF picture(rules.size_px, rules.size_px, 3);
    seen = Raster8(rules.size_px, rules.size_px);
    for (std::size_t i = 0; i < texels; ++i)
    {
        if (all[i].empty())
            continue;
        std::stable_sort(all[i].begin(), all[i].end(), [](const auto& a, const auto& b) { return a.heavier_than(b); });
        all[i].resize(static_cast<std::size_t>(rules.views_count) + 1);
        const auto color = blended(all[i]).rgb;
        std::copy(color.begin(), color.end(), picture.values.begin() + static_cast<std::ptrdiff_t>(3 * i));
        seen.values[i] = 1;
    }
    push_pull(picture, seen);
    return picture;
}

}  // namespace

TEST_CASE("exposures that pictures were given are solved, from every pixel of small maps and every second one of large ones")
{
    const int height = GENERATE(60, 480);
    const auto cameras = five_cameras();
    const std::vector<Vec3f> factors{
        {1.2F, 0.9F, 1}, {0.85F, 1.1F, 1}, {1, 1, 1.1F}, {1 / 1.2F, 1 / 0.9F, 1 / 1.1F}, {1 / 0.85F, 1 / 1.1F, 1}};
    std::vector<View> views;
    for (std::size_t i = 0; i < cameras.size(); ++i)
        views.push_back(view_of(cameras[i], height, smooth_paint, factors[i]));
    testing::TestRun run;
    const auto made = texture_of(views, rules_of(64), run);
    for (std::size_t i = 0; i < cameras.size(); ++i)
    {
        CAPTURE(i);
        const auto gain = gain_at(made.gains[i], {0.5F, 0.5F});
        CHECK(gain[0] * factors[i].x == Approx(1).epsilon(0.03));
        CHECK(gain[1] * factors[i].y == Approx(1).epsilon(0.03));
        CHECK(gain[2] * factors[i].z == Approx(1).epsilon(0.03));
    }
    CHECK(largest_error(made, smooth_paint) < 0.02);
    CHECK(made.error < 0.5 * made.error_without_gains);
}

TEST_CASE("the streamed texture is the one that sorting every sample gives, equally heavy ones in their order")
{
    std::vector<View> views;
    for (const Camera& camera : five_cameras())
        views.push_back(view_of(camera, 45, smooth_paint));
    for (const double x : {0.3, 0.6, 1.4})
        views.push_back(view_of(camera_at(x, 1.2, 1.2, 0.1), 45, smooth_paint, {1.1F, 1, 0.95F}));
    views.push_back(views[5]);  // All its samples are as heavy.
    for (int y = 30; y < 60; ++y)
        for (int x = 20; x < 60; ++x)
            views[6].picture.at(x, y, 0) = views[8].picture.at(x, y, 1) = 10;
    for (const int views_count : {3, 1, 16})
    {
        CAPTURE(views_count);
        TextureRules rules = rules_of(70);  // No whole number of blocks.
        rules.views_count = views_count;
        testing::TestRun one(1);
        const auto made = texture_of(views, rules, one);
        Raster8 seen;
        const RasterF slow = slow_texture(views, made.gains, made.sharpness, rules, seen);
        CHECK((made.picture == slow));
        CHECK((made.seen == seen));
        CHECK((views_count == 1) == (made.rejected_samples == 0));
    }
}

TEST_CASE("blurred pictures count less than their neighbors")
{
    const std::vector<std::string> walk(7, "walk");
    const auto factors = sharpness_factors({100, 100, 50, 100, 100, 200, 100}, walk);
    CHECK(factors == std::vector<double>{1, 1, 0.25, 1, 1, 4, 1});
    CHECK(sharpness_factors({100, 100, 25, 100, 100, 400, 100}, walk)[2] == 0.1);
    CHECK(sharpness_factors({1, 100, 100}, {"a", "b", "b"}) == std::vector<double>{1, 1, 1});
    CHECK(sharpness_factors({0, 0, 0}, {"a", "a", "a"}) == std::vector<double>{1, 1, 1});
    // Not compared with what was recorded long before.
    std::vector<double> recorded(20, 10.0);
    std::fill(recorded.begin() + 10, recorded.end(), 90.0);
    CHECK(sharpness_factors(recorded, std::vector<std::string>(20, "walk"))[19] == 1);
}

namespace
{

KeptSample sample(float weight, float value)
{
    return {weight, Four{value, value, value}};
}

constexpr float keep_all = 100;

}  // namespace

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

TEST_CASE("what disagrees with most of the weight does not count")
{
    std::vector<KeptSample> samples{sample(1, 0.95F), sample(0.9F, 0.41F), sample(0.9F, 0.4F), sample(0.9F, 0.39F), {}};
    const Blend blend = blended(samples);
    CHECK(blend.rgb[0] == Approx(0.4).margin(1e-3));
    CHECK(blend.rejected == 1);
    CHECK(blend.used == 4);
    CHECK(blended(samples, keep_all).rgb[0] > 0.5F);
    CHECK(blended(samples, keep_all).rejected == 0);
    // One channel is enough to disagree.
    samples[0] = {1, Four{0.4F, 0.4F, 0.9F}};
    CHECK(blended(samples).rgb[2] == Approx(0.4).margin(1e-3));
    // Small differences are averaged: 0.44 and 0.36 are as far from the middle on both sides.
    samples = {sample(1, 0.44F), sample(1, 0.36F), {}};
    CHECK(blended(samples).rgb[0] == Approx(0.4).margin(1e-3));
    CHECK(blended(samples).rejected == 0);
}

TEST_CASE("what is saturated stays white and gives way to what is not")
{
    const Four bright = Four{} + 1.2F, dark = Four{} + 0.8F;
    BestSamples best(2, 3);
    const KeptSample white = exposed(1, Four{1, 1, 1}, Four{0.8F, 0.95F, 0.7F});
    best.add(std::vector<ExposedSample>{{0, white}, {1, white}, {0, exposed(0.5F, Four{0.85F, 0.5F, 0.4F}, bright)}});
    CHECK(best.of(1)[0].rgb() == std::array<float, 3>{1, 1, 1});
    CHECK(best.of(1)[0].weight() == Approx(0.3).epsilon(0.01));
    CHECK(best.of(0)[0].rgb()[2] == Approx(0.48).margin(1e-4));
    CHECK(best.of(0)[1].rgb()[0] == 1);
    // Half way: 0.95 is at the middle of the step, so half of the gain and half of white.
    const KeptSample half = exposed(1, Four{0.95F, 0.5F, 0}, dark);
    CHECK(half.rgb()[0] == Approx(0.95 * 0.9).margin(1e-4));
    CHECK(half.rgb()[1] == Approx(0.5 * 0.9).margin(1e-4));
    CHECK(half.weight() == Approx(0.65).epsilon(0.01));
}
