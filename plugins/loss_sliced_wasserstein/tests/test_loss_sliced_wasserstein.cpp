#include "slices.h"

#include <fresco/progress.h>
#include <fresco/random.h>
#include <fresco/torch/testing.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace
{

torch::Tensor numbers(std::int64_t rows, std::int64_t columns, std::uint64_t seed)
{
    fresco::Random random(seed);
    auto values = at::empty({rows, columns}, at::kDouble);
    for (std::int64_t i = 0; i < values.numel(); ++i)
        values.data_ptr<double>()[i] = random.uniform();
    return values;
}

torch::Tensor picture(std::int64_t height, std::int64_t width, std::uint64_t seed)
{
    return numbers(3, height * width, seed).reshape({3, height, width});
}

std::vector<double> projected(const torch::Tensor& features, const torch::Tensor& direction)
{
    std::vector<double> result;
    for (std::int64_t i = 0; i < features.size(1); ++i)
    {
        double sum = 0;
        for (std::int64_t c = 0; c < features.size(0); ++c)
            sum += features[c][i].item<double>() * direction[c].item<double>();
        result.push_back(sum);
    }
    std::sort(result.begin(), result.end());
    return result;
}

/// Heitz et al., equation 4, one number at a time in double precision.
double slow_distance(const torch::Tensor& features, const torch::Tensor& target, const torch::Tensor& directions)
{
    double sum = 0;
    for (std::int64_t k = 0; k < directions.size(0); ++k)
    {
        const auto ours = projected(features, directions[k]);
        const auto style = projected(target, directions[k]);
        const auto last = static_cast<double>(style.size() - 1);
        for (std::size_t i = 0; i < ours.size(); ++i)
        {
            const double place = std::clamp(
                (static_cast<double>(i) + 0.5) / static_cast<double>(ours.size()) * static_cast<double>(style.size()) - 0.5, 0.0,
                last);
            const double low = std::floor(place);
            const double above = style[static_cast<std::size_t>(std::min(low + 1, last))];
            const double value = style[static_cast<std::size_t>(low)] * (1 - (place - low)) + above * (place - low);
            sum += (ours[i] - value) * (ours[i] - value);
        }
    }
    return sum / static_cast<double>(directions.size(0) * features.size(1));
}

struct Fixture
{
    fresco::Progress progress;
    fresco::PrepareContext context;

    Fixture()
    {
        context.style = {picture(8, 9, 1), picture(20, 20, 2) * 0.5};
        context.seed = 5;
        context.progress = &progress;
    }

    std::unique_ptr<fresco::Loss> make(const std::string& options) const
    {
        auto loss = fresco::testing::loss_on_colors(FRESCO_PLUGIN_FILE, "loss.sliced_wasserstein", options);
        loss->prepare(context);
        return loss;
    }
};

}  // namespace

TEST_CASE("entries take the value of their rank")
{
    const auto values = at::tensor({5.0, -1.0, 3.0, 4.0}, at::kDouble).reshape({1, 4});
    const auto equal = sliced::of_same_rank(values, at::tensor({10.0, 20.0, 30.0, 40.0}, at::kDouble).reshape({1, 4}));
    CHECK(at::equal(equal, at::tensor({40.0, 10.0, 20.0, 30.0}, at::kDouble).reshape({1, 4})));
    // Two entries stretched to four: places -0.25, 0.25, 0.75, 1.25 between them.
    const auto stretched = sliced::of_same_rank(values, at::tensor({0.0, 8.0}, at::kDouble).reshape({1, 2}));
    CHECK(at::equal(stretched, at::tensor({8.0, 0.0, 2.0, 6.0}, at::kDouble).reshape({1, 4})));
    const auto one = sliced::of_same_rank(values, at::full({1, 1}, 7.0, at::kDouble));
    CHECK(at::equal(one, at::full({1, 4}, 7.0, at::kDouble)));
    CHECK(at::equal(sliced::sorted_rows(values), at::tensor({-1.0, 3.0, 4.0, 5.0}, at::kDouble).reshape({1, 4})));
}

TEST_CASE("directions have length 1 and point everywhere alike")
{
    const auto directions = sliced::random_directions(4000, 5, 3, at::kDouble);
    CHECK(at::allclose((directions * directions).sum(1), at::ones({4000}, at::kDouble)));
    CHECK(directions.mean(0).abs().max().item<double>() < 0.03);
    const auto products = directions.t().mm(directions) / 4000;
    CHECK((products - at::eye(5, at::kDouble) / 5).abs().max().item<double>() < 0.02);
    CHECK(at::equal(directions, sliced::random_directions(4000, 5, 3, at::kDouble)));
    CHECK_FALSE(at::equal(directions, sliced::random_directions(4000, 5, 4, at::kDouble)));
}

TEST_CASE("the distance agrees with one computed number by number")
{
    const auto directions = sliced::random_directions(7, 4, 1, at::kDouble);
    for (const std::int64_t target_count : {1, 13, 40, 77})
    {
        const auto features = numbers(4, 40, 2);
        const auto target = numbers(4, target_count, 3) * 1.5 - 0.2;
        const double expected = slow_distance(features, target, directions);
        CHECK(sliced::distance(features, target, directions).item<double>() == Approx(expected).epsilon(1e-12));
        CHECK(sliced::distance(features.to(at::kFloat), target.to(at::kFloat), directions.to(at::kFloat)).item<double>() ==
              Approx(expected).epsilon(1e-5));
    }
}

TEST_CASE("a shift is felt along each direction, the order of the points is not")
{
    const auto features = numbers(3, 50, 4);
    const auto directions = sliced::random_directions(6, 3, 5, at::kDouble);
    const auto mixed = features.index_select(1, at::arange(49, -1, -1, at::kLong));
    CHECK(sliced::distance(features, mixed, directions).item<double>() == Approx(0).margin(1e-20));
    const auto shift = at::tensor({0.3, -0.2, 0.5}, at::kDouble);
    const double expected = directions.mv(shift).pow(2).mean().item<double>();
    CHECK(sliced::distance(features + shift.unsqueeze(1), features, directions).item<double>() == Approx(expected));
}

TEST_CASE("loss.sliced_wasserstein's gradient agrees with finite differences")
{
    const Fixture fixture;
    const auto loss = fixture.make(R"({"layers": "b, a", "layer_weights": [2, 0.5], "targets": "both", "directions_count": 5})");
    const auto start = picture(4, 6, 7);
    auto mask = at::ones({4, 6}, at::kBool);
    mask[0][1] = false;
    const auto fine = mask.logical_and(at::arange(6, at::kLong) < 3);
    const auto value = [&](const torch::Tensor& image)
    {
        fresco::testing::PicturePart part(image, start, mask, fine);
        part.step_index = 3;
        const auto terms = loss->evaluate(part);
        REQUIRE(terms.size() == 2);
        CHECK(terms[0].layer == "b");
        return terms[0].value + terms[1].value;
    };
    auto variable = start.clone().requires_grad_();
    value(variable).backward();
    const double step = 1e-6;
    for (std::int64_t i = 0; i < start.numel(); ++i)
    {
        auto up = start.clone();
        auto down = start.clone();
        up.data_ptr<double>()[i] += step;
        down.data_ptr<double>()[i] -= step;
        const double slope = (value(up).item<double>() - value(down).item<double>()) / (2 * step);
        CHECK(variable.grad().flatten()[i].item<double>() == Approx(slope).epsilon(1e-5).margin(1e-9));
    }
}

TEST_CASE("loss.sliced_wasserstein draws by the part's seed, compares sizes with their pixels, and skips what is not seen")
{
    const Fixture fixture;
    const auto image = picture(16, 16, 8);
    const auto all = at::ones({16, 16}, at::kBool);
    const auto none = at::zeros({16, 16}, at::kBool);
    const auto value = [&](const std::string& options, const torch::Tensor& fine, std::int64_t step)
    {
        fresco::testing::PicturePart part(image, image, all, fine);
        part.step_index = step;
        const auto terms = fixture.make(options)->evaluate(part);
        return terms.empty() ? -1.0 : terms.at(0).value.item<double>();
    };
    CHECK(value("{}", all, 0) == value("{}", all, 0));
    CHECK(value("{}", all, 0) != value("{}", all, 1));
    CHECK(value("{}", none, 0) == -1);
    const double coarse = value(R"({"targets": "coarse"})", none, 0);
    CHECK(value(R"({"targets": "both"})", none, 0) == coarse);
    CHECK(value(R"({"targets": "both"})", all, 0) > coarse);
    // 16 of the 256 features say about the same.
    const double some = value(R"({"targets": "coarse", "max_samples": 16})", all, 0);
    CHECK(some != coarse);
    CHECK(some == Approx(coarse).epsilon(0.7));
    const auto loss = fixture.make("{}");
    CHECK(loss->needs().features.at(0).names == std::vector<std::string>{"a"});
    CHECK(loss->state().empty());
}

TEST_CASE("descending loss.sliced_wasserstein gives a picture the style's colours")
{
    const Fixture fixture;
    const auto loss = fixture.make("{}");
    auto image = picture(12, 12, 9) * 0.2;
    for (int step = 0; step < 150; ++step)
    {
        auto variable = image.clone().requires_grad_();
        fresco::testing::PicturePart part(variable, image);
        part.step_index = step;
        loss->evaluate(part).at(0).value.backward();
        image = image - variable.grad() * 100;
    }
    const auto style = fixture.context.style.fine.flatten(1);
    const auto directions = sliced::random_directions(50, 3, 99, at::kDouble);
    CHECK(sliced::distance(image.flatten(1), style, directions).item<double>() < 2e-4);
    CHECK(sliced::distance(picture(12, 12, 9).flatten(1) * 0.2, style, directions).item<double>() > 0.05);
}

TEST_CASE("value and gradient are the same bytes for any thread count")
{
    const int before = at::get_num_threads();
    const auto features = numbers(16, 5000, 10).to(at::kFloat);
    const auto target = numbers(16, 3000, 11).to(at::kFloat);
    const auto directions = sliced::random_directions(16, 16, 12, at::kFloat);
    const auto run = [&](int threads)
    {
        at::set_num_threads(threads);
        auto variable = features.clone().requires_grad_();
        const auto value = sliced::distance(variable, target, directions);
        value.backward();
        return std::pair{value.detach(), variable.grad()};
    };
    const auto one = run(1);
    const auto two = run(2);
    at::set_num_threads(before);
    CHECK(at::equal(one.first, two.first));
    CHECK(at::equal(one.second, two.second));
}
