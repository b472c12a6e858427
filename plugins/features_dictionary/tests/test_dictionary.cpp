#include "dictionary.h"
#include "spherical_k_means.h"
#include "whitening.h"

#include <fresco/error.h>
#include <fresco/random.h>
#include <fresco/testing.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <catch2/catch.hpp>

#include <cmath>
#include <memory>

namespace
{

/// A picture with edges of every direction and some noise.
torch::Tensor rings(std::int64_t height, std::int64_t width)
{
    auto picture = at::empty({3, height, width}, at::kFloat);
    fresco::Random random(7);
    float* out = picture.data_ptr<float>();
    for (std::int64_t c = 0; c < 3; ++c)
        for (std::int64_t y = 0; y < height; ++y)
            for (std::int64_t x = 0; x < width; ++x)
            {
                const double radius = std::hypot(static_cast<double>(x) - 20, static_cast<double>(y) - 30);
                *out++ = static_cast<float>(0.5 + 0.4 * std::sin(radius / (2 + static_cast<double>(c))) + 0.05 * random.normal());
            }
    return picture;
}

dictionary::Dictionary learned(int patches = 1500, std::uint64_t seed = 3)
{
    fresco::Progress progress;
    return dictionary::Dictionary::learn(rings(80, 96), {.patches = patches, .iterations = 3, .seed = seed}, progress);
}

}  // namespace

TEST_CASE("The generator gives the numbers of splitmix64")
{
    fresco::Random random(1234567);
    CHECK(random.bits() == 6457827717110365317ULL);
    CHECK(random.bits() == 3203168211198807973ULL);
    double sum = 0;
    double squares = 0;
    for (int i = 0; i < 20'000; ++i)
    {
        const double value = random.normal();
        sum += value;
        squares += value * value;
    }
    CHECK(sum / 20'000 == Approx(0).margin(0.03));
    CHECK(squares / 20'000 == Approx(1).margin(0.03));
}

TEST_CASE("Whitened samples have the covariance that PCA whitening gives")
{
    // Two independent directions of variance 4 and 1, turned by 30 degrees.
    fresco::Random random(5);
    auto samples = at::empty({20'000, 2}, at::kFloat);
    const double c = std::cos(0.5236);
    const double s = std::sin(0.5236);
    for (std::int64_t i = 0; i < samples.size(0); ++i)
    {
        const double a = 2 * random.normal();
        const double b = random.normal();
        samples[i][0] = c * a - s * b + 3;
        samples[i][1] = s * a + c * b;
    }
    const auto whitening = dictionary::learn_whitening(samples, 0.1);
    CHECK(whitening.mean[0].item<double>() == Approx(3).margin(0.05));
    const auto white = (samples - whitening.mean).matmul(whitening.transform.t()).to(at::kDouble);
    const auto covariance = white.t().matmul(white) / 20'000.0;
    // Eigenvalues 4 / (4 + 0.25) and 1 / (1 + 0.25), whatever the rotation.
    const double trace = covariance.trace().item<double>();
    const double determinant = (covariance[0][0] * covariance[1][1] - covariance[0][1] * covariance[1][0]).item<double>();
    CHECK(trace == Approx(4 / 4.25 + 1 / 1.25).epsilon(0.02));
    CHECK(determinant == Approx(4 / 4.25 / 1.25).epsilon(0.03));
    // One direction only, or no variance at all: finite.
    CHECK(at::isfinite(dictionary::learn_whitening(at::ones({10, 3}), 0.1).transform).all().item<bool>());
}

TEST_CASE("Spherical k-means finds three directions")
{
    fresco::Random random(1);
    auto samples = at::empty({300, 3}, at::kFloat);
    for (std::int64_t i = 0; i < 300; ++i)
        for (std::int64_t j = 0; j < 3; ++j)
            samples[i][j] = (i % 3 == j ? 5.0 : 0.0) + 0.2 * random.normal();
    fresco::Progress progress;
    const auto centres = dictionary::spherical_k_means(samples, 3, 12, random, progress);
    for (std::int64_t j = 0; j < 3; ++j)
        CHECK(centres.select(1, j).max().item<double>() > 0.99);
    CHECK(at::allclose(centres.pow(2).sum(1), at::ones({3})));
    // More centres than samples, samples of length zero: unit vectors all the same.
    const auto many = dictionary::spherical_k_means(at::zeros({2, 3}), 5, 2, random, progress);
    CHECK(at::allclose(many.pow(2).sum(1), at::ones({5})));
}

TEST_CASE("Responses are centred and scaled before the rectifier")
{
    const auto dictionary = learned();
    const auto picture = rings(80, 96);
    const auto& first = dictionary.filters().front();
    const auto responses = at::conv2d(picture.unsqueeze(0), first.filters, first.bias).flatten(2).squeeze(0).to(at::kDouble);
    // Learned on the picture and a noisy copy together, so the picture alone has mean near 0 and a smaller deviation.
    CHECK(responses.mean(1).abs().max().item<double>() < 0.2);
    CHECK(responses.std().item<double>() > 0.2);
    CHECK(responses.std().item<double>() < 1.0);
}

TEST_CASE("The layers have the stated channels, sizes and reach")
{
    const auto dictionary = learned();
    const auto layers = dictionary::Dictionary::layers();
    const auto picture = rings(83, 101);
    const auto maps = dictionary.encode(picture, 4);
    REQUIRE(maps.size() == 4);
    auto changed = picture.clone();
    const std::int64_t x = 50;
    changed.select(2, x).add_(0.5);
    const auto after = dictionary.encode(changed, 4);
    for (std::size_t i = 0; i < 4; ++i)
    {
        CHECK(maps[i].size(0) == layers[i].channels);
        CHECK(maps[i].size(1) == 83 / layers[i].stride);
        CHECK(maps[i].size(2) == 101 / layers[i].stride);
        const auto touched = (maps[i] - after[i]).abs().amax(std::vector<std::int64_t>{0, 1}).nonzero().squeeze(1);
        // Every cell that changed has the column in reach, and the reach is not overstated.
        const auto reach = [&](std::int64_t cell) {
            return std::max({cell * layers[i].stride - x, x - (cell + 1) * layers[i].stride + 1, std::int64_t{0}});
        };
        std::int64_t farthest = 0;
        for (std::int64_t k = 0; k < touched.numel(); ++k)
            farthest = std::max(farthest, reach(touched[k].item<std::int64_t>()));
        CHECK(farthest <= layers[i].margin_px);
        CHECK(farthest > layers[i].margin_px - layers[i].stride);
    }
    CHECK(at::equal(maps[0].narrow(0, 64, 3), picture));
    CHECK(dictionary.encode(picture, 2).size() == 2);
}

TEST_CASE("Small pictures give small or empty maps, not errors")
{
    const auto dictionary = learned();
    const auto maps = dictionary.encode(rings(5, 3), 4);
    CHECK(maps[0].sizes() == at::IntArrayRef({67, 5, 3}));
    CHECK(maps[1].sizes() == at::IntArrayRef({96, 2, 1}));
    CHECK(maps[2].numel() == 0);
    CHECK(maps[3].sizes() == at::IntArrayRef({128, 0, 0}));
}

TEST_CASE("Gradients through the dictionary agree with finite differences")
{
    const auto dictionary = learned();
    const auto picture = rings(16, 16).to(at::kDouble);
    const auto value = [&](const torch::Tensor& p)
    {
        torch::Tensor sum = at::zeros({}, at::kDouble);
        for (const auto& map : dictionary.encode(p, 4))
            sum = sum + map.pow(2).mean();
        return sum;
    };
    auto variable = picture.clone().requires_grad_();
    value(variable).backward();
    for (std::int64_t i = 0; i < picture.numel(); i += 61)
    {
        auto up = picture.clone();
        auto down = picture.clone();
        // Short, so that no rectifier switches on the way.
        up.view({-1})[i] += 1e-7;
        down.view({-1})[i] -= 1e-7;
        const double slope = (value(up).item<double>() - value(down).item<double>()) / 2e-7;
        CHECK(variable.grad().flatten()[i].item<double>() == Approx(slope).epsilon(1e-3).margin(1e-7));
    }
}

TEST_CASE("Learning and encoding give the same bytes for any thread count, other bytes for another seed")
{
    const int before = at::get_num_threads();
    const auto run = [&](int threads, std::uint64_t seed)
    {
        at::set_num_threads(threads);
        auto picture = rings(80, 96).requires_grad_();
        const auto maps = learned(1500, seed).encode(picture, 4);
        (maps[0].pow(2).sum() + maps[3].pow(2).sum()).backward();
        return std::vector<torch::Tensor>{maps[0].detach(), maps[3].detach(), picture.grad()};
    };
    const auto one = run(1, 3);
    const auto two = run(2, 3);
    const auto other = run(2, 4);
    at::set_num_threads(before);
    for (std::size_t i = 0; i < one.size(); ++i)
    {
        CHECK(at::equal(one[i], two[i]));
        CHECK_FALSE(at::equal(one[i], other[i]));
    }
}

TEST_CASE("features.dictionary as a component")
{
    auto made = fresco::testing::make_from_plugin(FRESCO_PLUGIN_FILE, "features.dictionary");
    auto& network = dynamic_cast<fresco::FeatureNetwork&>(*made);
    fresco::testing::TestFactory factory;
    network.configure(fresco::Value::Map{{"patches", 1000}, {"iterations", 2}}, factory);
    fresco::Progress progress;
    fresco::PrepareContext context;
    context.progress = &progress;
    context.style.fine = rings(40, 90);
    CHECK_THROWS_WITH(network.prepare(context), Catch::Contains("90 x 40") && Catch::Contains("64"));
    context.style.fine = rings(80, 90);
    network.prepare(context);
    const auto maps = network.encode(rings(32, 32), {"d3", "d1"});
    REQUIRE(maps.size() == 2);
    CHECK(maps[0].size(0) == 128);
    CHECK(maps[1].size(0) == 67);
    CHECK_THROWS_WITH(network.encode(rings(32, 32), {"relu1_1"}),
                      Catch::Contains("relu1_1") && Catch::Contains("d1, d2, d3, d4"));
}
