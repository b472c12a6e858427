#include "catch.h"
#include "gram_matrix.h"

#include <fresco/torch/testing.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <torch/csrc/autograd/autograd.h>

#include <cmath>
#include <memory>

namespace
{

/// Values in [0, 1) without a pattern that a wrong index would hide.
torch::Tensor some_features(std::int64_t channels, std::int64_t count)
{
    auto values = at::empty({channels, count}, at::kDouble);
    for (std::int64_t i = 0; i < values.numel(); ++i)
        values.data_ptr<double>()[i] = std::fmod(0.7548776662 * static_cast<double>(i * i % 7919 + i), 1.0);
    return values;
}

/// Channels of a pixel in a row, or pixels of a channel.
torch::Tensor laid_out(const torch::Tensor& features, bool turned)
{
    return (turned ? features.t().contiguous().t() : features).detach().clone().requires_grad_();
}

}  // namespace

TEST_CASE("The Gram matrix is the product with the transpose, of many features in blocks and of many channels half mirrored")
{
    for (const auto& features : {some_features(5, 9000), some_features(300, 40)})
        for (const bool turned : {false, true})
        {
            const auto second = gram::gram_matrix(laid_out(features, turned).detach().to(at::kFloat));
            const auto count = static_cast<double>(features.size(1));
            CHECK(second.allclose((at::mm(features, features.t()) / count).to(at::kFloat), 1e-5, 1e-6));
            CHECK(second.equal(second.t()));
        }
}

TEST_CASE("The gradient of the Gram matrix agrees with finite differences")
{
    const auto features = some_features(3, 7);
    const auto factor = some_features(3, 3);
    const auto value = [&](const torch::Tensor& f) { return gram::mean_square_difference(gram::gram_matrix(f), factor); };
    auto variable = features.clone().requires_grad_();
    value(variable).backward();
    for (std::int64_t i = 0; i < features.numel(); ++i)
    {
        const auto step = 1e-6 * (at::arange(features.numel()) == i).reshape_as(features).to(at::kDouble);
        const double slope = (value(features + step) - value(features - step)).item<double>() / 2e-6;
        CHECK(variable.grad().flatten()[i].item<double>() == Approx(slope).epsilon(1e-5).margin(1e-8));
    }
}

TEST_CASE("Gram matrices of all and of the fine features are those of each, and so are their gradients")
{
    const auto features = some_features(7, 500);
    const auto weights = some_features(7, 7);
    const auto value = [&](const torch::Tensor& all, const std::optional<torch::Tensor>& fine)
    {
        const auto of_all = (all * weights).sum();
        return fine ? of_all + 3 * (*fine * weights.t()).sum() : of_all;
    };
    const auto symmetric = [&](double factor) { return factor * (weights + weights.t()); };
    for (const std::int64_t fine_count : {0, 100, 500})
        for (const bool turned : {false, true})
        {
            CAPTURE(fine_count, turned);
            const auto slow_input = laid_out(features, turned);
            const auto fine_only = slow_input.narrow(1, 0, fine_count);
            const auto slow =
                value(gram::gram_matrix(slow_input), fine_count > 0 ? std::optional(gram::gram_matrix(fine_only)) : std::nullopt);
            slow.backward();
            const auto fast_input = laid_out(features, turned);
            const auto both = gram::gram_of_both(fast_input, fine_count);
            REQUIRE(both.fine.has_value() == (fine_count > 0));
            const auto fast = value(both.all, both.fine);
            fast.backward();
            CHECK(fast.item<double>() == Approx(slow.item<double>()).epsilon(1e-12));
            CHECK(fast_input.grad().allclose(slow_input.grad(), 1e-11, 1e-14));

            // As the distance of both to their targets, also in float32 by products of our own.
            const auto plain_input = laid_out(features, turned);
            const auto matrices = gram::gram_of_both(plain_input, fine_count);
            auto plain = gram::mean_square_difference(matrices.all, symmetric(0.1));
            if (matrices.fine)
                plain = plain + gram::mean_square_difference(*matrices.fine, symmetric(0.3));
            (3 * plain).backward();
            for (const auto type : {at::kDouble, at::kFloat})
            {
                const auto input = laid_out(features.to(type), turned);
                const std::vector<fresco::LevelColumns> columns{{input.size(1), fine_count, 1}};
                const auto elements = static_cast<double>(input.size(0) * input.size(0));
                const auto weights = gram::gram_weights(columns, true, 3 / elements).to(type);
                const auto distance =
                    gram::gram_distance(input, columns, at::stack({symmetric(0.1), symmetric(0.3)}).to(type), weights);
                distance.backward();
                const bool is_exact = type == at::kDouble;
                CHECK(distance.item<double>() == Approx(3 * plain.item<double>()).epsilon(is_exact ? 1e-12 : 1e-5));
                CHECK(
                    input.grad().to(at::kDouble).allclose(plain_input.grad(), is_exact ? 1e-11 : 1e-4, is_exact ? 1e-14 : 1e-6));
            }
        }
}

TEST_CASE("Levels are compared together as one after the other, each with its share")
{
    at::manual_seed(4);
    const std::vector<fresco::LevelColumns> levels{{9, 4, 0.3}, {0, 0, 0.2}, {5, 5, 0.4}, {7, 0, 0.1}};
    const auto features = at::rand({3, 21}, at::kDouble).set_requires_grad(true);
    const auto targets = at::rand({2, 3, 3}, at::kDouble);
    const auto symmetric = targets + targets.transpose(1, 2);
    const auto together = gram::gram_distance(features, levels, symmetric, gram::gram_weights(levels, true, 2.0 / 9));
    auto apart = at::zeros({}, at::kDouble);
    std::int64_t first = 0;
    for (const auto& level : levels)
    {
        const auto compare = [&](std::int64_t count, std::int64_t target)
        {
            const auto own = features.narrow(1, first, count);
            if (count > 0)
                apart = apart + 2 * level.share * (at::matmul(own, own.t()) / count - symmetric[target]).pow(2).mean();
        };
        compare(level.count, 0);
        compare(level.fine_count, 1);
        first += level.count;
    }
    CHECK(together.item<double>() == Approx(apart.item<double>()).epsilon(1e-12));
    const auto gradient = torch::autograd::grad({together}, {features})[0];
    CHECK(gradient.allclose(torch::autograd::grad({apart}, {features})[0], 1e-11, 1e-14));
}

namespace
{

struct Fixture
{
    fresco::Progress progress;
    fresco::PrepareContext context;

    Fixture()
    {
        // One fine size with two colors in equal parts, a coarse one that is all (0, 1, 0).
        context.style.fine = at::zeros({3, 2, 2}, at::kDouble);
        context.style.fine[0].fill_(1);
        context.style.fine[1][0].fill_(1);
        context.style.coarse = at::zeros({3, 4, 4}, at::kDouble);
        context.style.coarse[1].fill_(1);
        context.progress = &progress;
    }

    std::unique_ptr<fresco::Loss> make(const std::string& options)
    {
        return fresco::testing::loss_on_colors(FRESCO_PLUGIN_FILE, "loss.gram", options);
    }

    std::vector<fresco::LossTerm> evaluate(const std::string& options, fresco::Part& part)
    {
        auto loss = make(options);
        loss->prepare(context);
        return loss->evaluate(part);
    }
};

torch::Tensor picture_of(double r, double g, double b)
{
    return at::tensor({r, g, b}, at::kDouble).reshape({3, 1, 1}).expand({3, 4, 4}).contiguous();
}

}  // namespace

TEST_CASE("loss.gram by hand")
{
    Fixture fixture;
    fresco::testing::PicturePart part(picture_of(1, 0, 0), picture_of(0, 0, 0));
    const auto value = [&](const std::string& options)
    {
        const auto terms = fixture.evaluate(options, part);
        REQUIRE(terms.size() == 1);
        CHECK(terms[0].layer == "a");
        return terms[0].value.item<double>();
    };
    // Gram of the style is [1 .5 0; .5 .5 0; 0 0 0], ours [1 0 0; 0 0 0; 0 0 0].
    CHECK(value("{}") == Approx(0.75 / 9));
    // Coarse: Gram [0 0 0; 0 1 0; 0 0 0].
    CHECK(value(R"({"targets": "coarse"})") == Approx(2.0 / 9));
    // Both, with a factor.
    const auto terms = fixture.evaluate(R"({"targets": "both", "layers": "b, a", "layer_weights": [0, 10]})", part);
    REQUIRE(terms.size() == 2);
    CHECK(terms[0].value.item<double>() == Approx(0));
    CHECK(terms[1].layer == "a");
    CHECK(terms[1].value.item<double>() == Approx(27.5 / 9));
}

TEST_CASE("loss.gram: no passing pixel leaves only the coarse target; no pixel at all leaves nothing")
{
    Fixture fixture;
    auto picture = picture_of(0, 1, 0);
    picture.narrow(2, 2, 2).fill_(1);
    const auto all = at::ones({4, 4}, at::kBool);
    const auto none = at::zeros({4, 4}, at::kBool);
    fresco::testing::PicturePart steep(picture, picture, all, none);
    CHECK(fixture.evaluate(R"({"targets": "both"})", steep).at(0).value.item<double>() == Approx(8 * 0.25 / 9));
    CHECK(fixture.evaluate("{}", steep).empty());
    fresco::testing::PicturePart nothing(picture, picture, none, none);
    CHECK(fixture.evaluate(R"({"targets": "both"})", nothing).empty());
}

TEST_CASE("loss.gram's errors and needs")
{
    Fixture fixture;
    CHECK_THROWS_WITH(fixture.make(R"({"layers": "a, c"})")->prepare(fixture.context), Catch::Contains("a, b"));
    CHECK_THROWS_WITH(fixture.make(R"({"layer_weights": [1, 2]})")->prepare(fixture.context), Catch::Contains("layer_weights"));
    CHECK_THROWS_WITH(fixture.make(R"({"rule": "released"})")->prepare(fixture.context), Catch::Contains("rule: released"));
    fixture.context.style.fine = at::zeros({3, 1, 1}, at::kDouble);
    CHECK_THROWS_WITH(fixture.make(R"({"layers": "b"})")->prepare(fixture.context), Catch::Contains("too small"));

    auto loss = fixture.make("{}");
    CHECK(loss->needs().features.at(0).names.empty());
    loss->prepare(Fixture().context);
    CHECK(loss->needs().features.at(0).names == std::vector<std::string>{"a"});
}

TEST_CASE("the released rule compares passing and failing pixels with the coarse target, each on their own")
{
    Fixture fixture;
    // Left half (passing) all green like the coarse target, right half white: Gram of ones, 8 of 9 entries off by 1.
    auto picture = picture_of(0, 1, 0);
    picture.narrow(2, 2, 2).fill_(1);
    const auto all = at::ones({4, 4}, at::kBool);
    auto fine = at::zeros({4, 4}, at::kBool);
    fine.narrow(1, 0, 2).fill_(true);
    fresco::testing::PicturePart part(picture, picture, all, fine);
    const auto value = [&](const std::string& options, fresco::Part& of)
    { return fixture.evaluate(options, of).at(0).value.item<double>(); };
    CHECK(value(R"({"rule": "released", "targets": "coarse"})", part) == Approx(8.0 / 9));
    // And the fine one on passing pixels: [1 .5 0; .5 .5 0; 0 0 0] against [0 0 0; 0 1 0; 0 0 0].
    CHECK(value(R"({"rule": "released", "targets": "both"})", part) == Approx((8 + 1.75) / 9));
    SECTION("where all pass, the coarse term comes once")
    {
        fresco::testing::PicturePart front(picture, picture, all, all);
        CHECK(value(R"({"rule": "released", "targets": "coarse"})", front) == Approx(8 * 0.25 / 9));
    }
    SECTION("where none pass, zeros are compared with both targets, at no gradient")
    {
        const auto term_and_gradient = [&](const std::string& options)
        {
            const auto leaf = picture.detach().clone().requires_grad_();
            fresco::testing::PicturePart steep(leaf, leaf, all, at::zeros({4, 4}, at::kBool));
            const auto term = fixture.evaluate(options, steep).at(0).value;
            term.backward();
            return std::pair(term.item<double>(), leaf.grad());
        };
        const auto both = term_and_gradient(R"({"rule": "released", "targets": "both"})");
        // One entry of the coarse target is 1; of the fine one, with two colors in equal parts, 1, 1/2, 1/2, 1/2.
        CHECK(both.first == Approx((8 * 0.25 + 1 + 1.75) / 9));
        CHECK(both.second.equal(term_and_gradient(R"({"targets": "coarse"})").second));
    }
}

namespace
{

/// A visit to a view of one color on the layer "a".
struct Visit
{
    double red = 0;
    std::int64_t view = 0;
    std::int64_t repeat = 0;
};

/// Σ (G - target)² / 9 for the fine style of the fixture, where G has `g` in the corner and nothing else.
double corner_distance(double g)
{
    return ((g - 1) * (g - 1) + 0.75) / 9;
}

}  // namespace

TEST_CASE("the Gram matrix is averaged over the last views, with state and restore")
{
    Fixture fixture;
    const std::string options = R"({"average_views_count": 3})";
    const std::vector<Visit> visits{{1, 7, 0}, {0.5, 8, 0}, {0.2, 8, 1}, {0.6, 9, 0}, {0.4, 7, 0}, {0.3, 7, 0}};
    // Squares of the reds that count: the second step on view 8 replaces the first; two visits to view 7 in a row are two.
    const std::vector<std::vector<double>> counted{
        {1}, {1, 0.25}, {1, 0.04}, {1, 0.04, 0.36}, {0.04, 0.36, 0.16}, {0.36, 0.16, 0.09}};
    const auto whole = fixture.make(options);
    whole->prepare(fixture.context);
    for (std::size_t step = 0; step < visits.size(); ++step)
    {
        double mean = 0;
        for (const double square : counted[step])
            mean += square / static_cast<double>(counted[step].size());
        auto picture = picture_of(visits[step].red, 0, 0).requires_grad_();
        fresco::testing::PicturePart part(picture, picture_of(0, 0, 0));
        part.step_index = static_cast<std::int64_t>(step);
        part.view_index = visits[step].view;
        part.repeat_index = visits[step].repeat;

        // A loss resumed from the earlier state gives the same, also when asked twice in a step.
        const auto resumed = fixture.make(options);
        resumed->prepare(fixture.context);
        resumed->restore(whole->state());
        const auto value = whole->evaluate(part).at(0).value;
        CHECK(value.item<double>() == Approx(corner_distance(mean)));
        CHECK(whole->evaluate(part).at(0).value.item<double>() == value.item<double>());
        CHECK(resumed->evaluate(part).at(0).value.item<double>() == value.item<double>());

        // The current view has one share in the mean: 2 (G - 1) / 9 · 2 red / count, over 16 pixels.
        value.backward();
        const double slope = 2 * (mean - 1) / 9 * 2 * visits[step].red / static_cast<double>(counted[step].size());
        CHECK(picture.grad()[0].sum().item<double>() == Approx(slope).margin(1e-12));
    }
    CHECK(whole->state().size() == 6);
}
