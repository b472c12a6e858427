#include "nearest.h"
#include "random_tensor.h"

#include <fresco/parallel.h>
#include <fresco/torch/testing.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include "catch.h"

#include <memory>

using fresco::testing::random_tensor;

namespace
{

torch::Tensor picture(std::int64_t height, std::int64_t width, std::uint64_t seed)
{
    return random_tensor({3, height, width}, seed, at::kDouble) + 0.5;
}

/// Zhang et al., equation 2, by all cosines at once: `features` C x N, `style` C x M.
double slow_distance(const torch::Tensor& features, const torch::Tensor& style)
{
    const auto cosines = at::mm((features / features.norm(2, 0)).t(), style / style.norm(2, 0));
    return (1 - std::get<0>(cosines.max(1))).mean().item<double>();
}

torch::Tensor style_rows(const torch::Tensor& style)
{
    return nnfm::unit_rows(style.t().contiguous());
}

struct Fixture
{
    fresco::Progress progress;
    fresco::PrepareContext context;

    Fixture()
    {
        context.style = {picture(5, 6, 1), picture(9, 10, 2)};
        context.progress = &progress;
    }

    std::unique_ptr<fresco::Loss> make(const std::string& options) const
    {
        auto loss = fresco::testing::loss_on_colors(FRESCO_PLUGIN_FILE, "loss.nnfm", options);
        loss->prepare(context);
        return loss;
    }
};

}  // namespace

TEST_CASE("the nearest by angle, by hand")
{
    const auto style = at::tensor({1.0, 0.0, 0.0, 1.0, 0.6, 0.8}, at::kDouble).reshape({3, 2});
    // (5, 0) is the first; (3, 4) the third exactly; (-1, 0) is at a right angle to the second; zero is like any.
    const auto features = at::tensor({5.0, 3.0, -1.0, 0.0, 0.0, 4.0, 0.0, 0.0}, at::kDouble).reshape({2, 4});
    const auto matches = nnfm::most_similar(nnfm::unit_rows(features.t().contiguous()), style);
    CHECK(at::equal(matches, at::tensor({0, 2, 1, 0}, at::kLong)));
    CHECK(nnfm::distance(features, style).item<double>() == Approx((0.0 + 0.0 + 1.0 + 1.0) / 4));
}

TEST_CASE("the distance agrees with one of all pairs, in either type")
{
    const auto features = random_tensor({5, 60}, 3, at::kDouble);
    const auto style = random_tensor({5, 33}, 4, at::kDouble);
    const double expected = slow_distance(features, style);
    CHECK(nnfm::distance(features, style_rows(style)).item<double>() == Approx(expected).epsilon(1e-12));
    CHECK(nnfm::distance(features.to(at::kFloat), style_rows(style.to(at::kFloat))).item<double>() ==
          Approx(expected).epsilon(1e-5));
}

TEST_CASE("blocks of the search change nothing, and every feature of the style finds itself")
{
    const auto style = style_rows(random_tensor({8, 9000}, 5));  // three blocks
    const auto own = at::arange(3, 9000, 13, at::kLong);         // two blocks
    CHECK(at::equal(nnfm::most_similar(style.index_select(0, own), style), own));
}

TEST_CASE("sampled columns: one of each run, by the seed, with a gradient only to those")
{
    auto features = at::arange(22, at::kDouble).reshape({2, 11}).requires_grad_();
    CHECK(at::equal(nnfm::sampled_columns(features, 11, 1), features));
    const auto sampled = nnfm::sampled_columns(features, 4, 5);
    REQUIRE(sampled.sizes() == at::IntArrayRef({2, 4}));
    CHECK(at::equal(sampled, nnfm::sampled_columns(features, 4, 5)));
    const std::int64_t borders[] = {0, 2, 5, 8, 11};
    bool differs = false;
    for (std::uint64_t seed = 0; seed < 20; ++seed)
    {
        const auto columns = nnfm::sampled_columns(features, 4, seed)[0];
        for (std::int64_t i = 0; i < 4; ++i)
        {
            const auto column = static_cast<std::int64_t>(columns[i].item<double>());
            CHECK((column >= borders[i] && column < borders[i + 1]));
        }
        differs = differs || !at::equal(columns, sampled[0]);
    }
    CHECK(differs);
    sampled.sum().backward();
    CHECK(features.grad().sum().item<double>() == 8);
}

TEST_CASE("loss.nnfm's gradient agrees with finite differences")
{
    const Fixture fixture;
    const auto loss = fixture.make(R"({"layers": "b, a", "layer_weights": [2, 0.5], "targets": "both"})");
    const auto start = picture(4, 6, 7);
    auto mask = at::ones({4, 6}, at::kBool);
    mask[0][1] = false;
    const auto fine = mask.logical_and(at::arange(6, at::kLong) < 3);
    const auto value = [&](const torch::Tensor& image)
    {
        fresco::testing::PicturePart part(image, start, mask, fine);
        const auto terms = loss->evaluate(part);
        REQUIRE(terms.size() == 2);
        CHECK(terms[0].layer == "b");
        return terms[0].value + terms[1].value;
    };
    auto variable = start.clone().requires_grad_();
    value(variable).backward();
    for (std::int64_t i = 0; i < start.numel(); ++i)
    {
        const auto step = 1e-7 * (at::arange(start.numel()) == i).reshape_as(start).to(at::kDouble);
        const double slope = (value(start + step) - value(start - step)).item<double>() / 2e-7;
        CHECK(variable.grad().flatten()[i].item<double>() == Approx(slope).epsilon(1e-4).margin(1e-8));
    }
}

TEST_CASE("a feature of zeros has no angle and no gradient")
{
    auto features = at::zeros({3, 2}, at::kFloat);
    features[0][1] = 2;
    features.requires_grad_();
    const auto value = nnfm::distance(features, at::eye(3, at::kFloat).narrow(0, 1, 2).contiguous());
    CHECK(value.item<float>() == 1);
    value.backward();
    CHECK(at::isfinite(features.grad()).all().item<bool>());
}

TEST_CASE("loss.nnfm compares sizes with their pixels and skips what is not seen")
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
    const auto whole = image.flatten(1);
    CHECK(value("{}", all, 0) == Approx(slow_distance(whole, fixture.context.style.fine.flatten(1))));
    CHECK(value("{}", none, 0) == -1);
    const double coarse = value(R"({"targets": "coarse"})", none, 0);
    CHECK(coarse == Approx(slow_distance(whole, fixture.context.style.coarse.flatten(1))));
    CHECK(value(R"({"targets": "both"})", none, 0) == coarse);
}
