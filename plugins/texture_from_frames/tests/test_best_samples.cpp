#include "best_samples.h"
#include "catch.h"

#include <fresco/random.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
using namespace fresco::from_frames;

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
