#include "catch.h"
#include "patches.h"
#include "random_tensor.h"
#include "search.h"

#include <fresco/testing.h>
#include <fresco/torch/testing.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <cmath>
#include <memory>

using fresco::testing::random_tensor;
namespace pm = patch_match;

TEST_CASE("Patches are rows in the order channel, y, x")
{
    const auto picture = random_tensor({3, 9, 12}, 1) + 0.5;
    const pm::PatchGrid grid{12, 9, 2};
    const auto rows = pm::extract_patches(picture, grid);
    CHECK(rows.sizes() == at::IntArrayRef({8, 147}));
    CHECK(at::equal(rows[6], picture.narrow(1, 2, 7).narrow(2, 4, 7).flatten()));
    // Not 6, where it would not fit, but the picture's end is covered.
    CHECK(at::equal(rows[7], picture.narrow(1, 2, 7).narrow(2, 5, 7).flatten()));
}

TEST_CASE("Style patches: every pixel's, or a coarser grid's, with principal directions")
{
    const auto picture = random_tensor({3, 20, 24}, 1) + 0.5;
    const auto all = pm::make_style_patches(picture, 1000, 147);
    CHECK(all.patches.size(0) == 14 * 18);
    CHECK(pm::make_style_patches(picture, 100, 4).patches.size(0) == 8 * 10);
    CHECK(all.total_variance ==
          Approx((all.patches - all.patches.mean(0)).pow(2).sum().item<double>() / (14 * 18)).epsilon(1e-4));
    // All directions keep lengths; the first is the strongest.
    CHECK(at::allclose(all.keys.pow(2).sum(1), (all.patches - all.mean).pow(2).sum(1), 1e-3, 1e-3));
    const auto strength = all.keys.pow(2).mean(0);
    CHECK((strength.narrow(0, 0, 146) >= strength.narrow(0, 1, 146) - 1e-5).all().item<bool>());
    const auto one_color = pm::make_style_patches(at::full({3, 20, 20}, 0.5F), 1000, 8);
    CHECK(at::isfinite(one_color.keys).all().item<bool>());
}

TEST_CASE("Many rows of patches have the derivative that libtorch finds, whatever the number of threads")
{
    const auto picture = random_tensor({3, 41, 33}, 1) + 0.5;
    const auto style = (random_tensor({5, 147}, 2) + 0.5) * 0.5;
    const pm::PatchGrid grid{33, 41, 2};
    auto nearest = at::arange(0, grid.count(), at::kInt).remainder(6) - 1;
    nearest = nearest.to(at::kInt).contiguous();
    const auto gradient = [&](int threads)
    {
        auto variable = picture.clone().requires_grad_();
        pm::robust_distance(variable, grid, nearest, style, 3, 0.8, threads).backward();
        return variable.grad();
    };
    CHECK(at::equal(gradient(1), gradient(3)));

    auto variable = picture.to(at::kDouble).requires_grad_();
    auto sum = at::zeros({}, at::kDouble);
    std::int64_t taking_part = 0;
    for (std::int64_t i = 0; i < grid.count(); ++i)
        if (const auto match = nearest[i].item<std::int64_t>(); match >= 0)
        {
            const auto patch = variable.narrow(1, grid.y(i), 7).narrow(2, grid.x(i), 7).flatten();
            sum = sum + ((patch - style[match].to(at::kDouble)).pow(2).sum() / 3 + 1e-4).pow(0.4);
            ++taking_part;
        }
    const auto mean = sum / static_cast<double>(taking_part);
    CHECK(pm::robust_distance(picture, grid, nearest, style, 3, 0.8, 2).item<double>() ==
          Approx(mean.item<double>()).epsilon(1e-5));
    mean.backward();
    CHECK(at::allclose(gradient(2).to(at::kDouble), variable.grad(), 1e-4, 1e-7));
}

TEST_CASE("A patch that equals its style patch has a finite gradient; none taking part has no value")
{
    const auto picture = random_tensor({3, 7, 7}, 1) + 0.5;
    const pm::PatchGrid grid{7, 7, 1};
    auto variable = picture.clone().requires_grad_();
    const auto value = pm::robust_distance(variable, grid, at::zeros({1}, at::kInt), picture.reshape({1, 147}), 1, 0.8, 1);
    value.backward();
    CHECK(value.item<double>() == Approx(std::pow(1e-4, 0.4)));
    CHECK(at::equal(variable.grad(), at::zeros_like(picture)));
    CHECK_FALSE(pm::robust_distance(picture, grid, at::full({1}, -1, at::kInt), picture.reshape({1, 147}), 1, 0.8, 1).defined());
}

namespace
{

double squares(const torch::Tensor& a, const torch::Tensor& b)
{
    return (a.to(at::kDouble) - b.to(at::kDouble)).pow(2).sum().item<double>();
}

}  // namespace

TEST_CASE("The search agrees with every distance computed one at a time")
{
    const pm::SearchInput input{.patches = random_tensor({40, 6}, 1) + 0.5,
                                .guide = random_tensor({40, 6}, 2) + 0.5,
                                .style = random_tensor({60, 6}, 3) + 0.5,
                                .guide_weight = 0.2,
                                .tolerance = 0.05};
    auto expected = at::empty({40, 60}, at::kDouble);
    for (std::int64_t i = 0; i < 40; ++i)
        for (std::int64_t j = 0; j < 60; ++j)
            expected[i][j] = squares(input.patches[i], input.style[j]) + 0.2 * squares(input.guide[i], input.style[j]);
    // A style patch that nothing resembles is near to something, too.
    expected = expected / (std::get<0>(expected.min(0)) + 0.05);
    const auto found = pm::nearest_patches(input, fresco::Progress{});
    CHECK(at::equal(found, expected.argmin(1).to(at::kInt)));
}

TEST_CASE("A patch that is not a number finds some style patch")
{
    auto patches = random_tensor({4, 6}, 1) + 0.5;
    patches[2].fill_(std::nan(""));
    const auto style = random_tensor({60, 6}, 3) + 0.5;
    const auto found = pm::nearest_patches({.patches = patches, .guide = patches, .style = style, .tolerance = 1}, {});
    CHECK(((found >= 0) & (found < 60)).all().item<bool>());
}

TEST_CASE("Blocks and threads change no result, and a style patch finds itself")
{
    const auto style = random_tensor({5000, 8}, 1) + 0.5;  // more than one block of style patches
    const auto own = at::arange(0, 5000, 16, at::kLong);
    const pm::SearchInput input{.patches = style.index_select(0, own),  // more than one block of queries
                                .guide = style.index_select(0, own),
                                .style = style,
                                .guide_weight = 0.2,
                                .tolerance = 1e9};
    const auto one = pm::nearest_patches(input, fresco::testing::TestRun(1));
    const auto two = pm::nearest_patches(input, fresco::testing::TestRun(3));
    CHECK(at::equal(one, two));
    for (std::int64_t i = 0; i < own.numel(); ++i)
        CHECK(squares(style[one[i].item<std::int64_t>()], style[own[i].item<std::int64_t>()]) < 1e-4);
}

namespace
{

torch::Tensor waves(std::int64_t height, std::int64_t width, double period)
{
    const auto along = (at::arange(width) + 2 * at::arange(height).unsqueeze(1)) / period;
    return (0.5 + 0.4 * at::sin(along + at::arange(3).reshape({3, 1, 1}))).to(at::kFloat);
}

struct Fixture
{
    fresco::testing::TestFactory factory;
    fresco::Progress progress;
    fresco::PrepareContext context;
    torch::Tensor camera = waves(40, 48, 9);

    Fixture()
    {
        context.style = {waves(64, 70, 3), waves(64, 70, 3)};
        context.camera_samples = {camera};
        context.progress = &progress;
    }

    std::unique_ptr<fresco::Loss> make(const std::string& options = "{}")
    {
        auto loss = fresco::testing::make_from_plugin<fresco::Loss>(FRESCO_PLUGIN_FILE, "loss.patch_match");
        loss->configure(fresco::parse_json(options, "test"), factory);
        loss->prepare(context);
        return loss;
    }

    double evaluate(fresco::Loss& loss, const torch::Tensor& picture, std::int64_t step, std::int64_t repeat,
                    std::int64_t view = 0)
    {
        fresco::testing::PicturePart part(picture, camera);
        part.step_index = step;
        part.repeat_index = repeat;
        part.view_index = view;
        return loss.evaluate(part).at(0).value.item<double>();
    }
};

}  // namespace

TEST_CASE("Descending loss.patch_match makes a picture of the style's patches")
{
    Fixture fixture;
    const auto loss = fixture.make();
    CHECK(loss->needs().picture);
    auto picture = fixture.camera.clone();
    const double before = fixture.evaluate(*loss, picture, 0, 0);
    for (int step = 0; step < 60; ++step)
    {
        auto variable = picture.clone().requires_grad_();
        fresco::testing::PicturePart part(variable, fixture.camera);
        part.step_index = step;
        part.repeat_index = step;
        loss->evaluate(part).at(0).value.backward();
        const auto gradient = variable.grad();
        REQUIRE(at::isfinite(gradient).all().item<bool>());
        picture = (picture - gradient.sign() * 0.01).clamp(0, 1);
    }
    CHECK(fixture.evaluate(*loss, picture, 64, 64) < 0.5 * before);
}

TEST_CASE("Matches are refreshed every few steps on a view, once per step")
{
    Fixture fixture;
    const auto loss = fixture.make();
    const auto other = waves(40, 48, 4);
    fixture.evaluate(*loss, fixture.camera, 0, 0);
    const auto fresh = [&](const torch::Tensor& picture)
    {
        const auto fresh = fixture.make();
        return fixture.evaluate(*fresh, picture, 0, 0);
    };
    const double kept = fixture.evaluate(*loss, other, 1, 1);
    CHECK(kept > fresh(other));
    CHECK(fixture.evaluate(*loss, other, 8, 8) == fresh(other));
    // A rule that evaluates twice in one step sees one function.
    CHECK(fixture.evaluate(*loss, fixture.camera, 8, 8) > fresh(fixture.camera));
    // Another view is searched at once, whatever its count.
    CHECK(fixture.evaluate(*loss, fixture.camera, 9, 1, 1) == fresh(fixture.camera));
}

TEST_CASE("Only patches wholly inside the mask take part")
{
    Fixture fixture;
    const auto loss = fixture.make();
    auto mask = at::ones({40, 48}, at::kBool);
    mask.narrow(1, 30, 18).fill_(false);
    auto picture = waves(40, 48, 5).requires_grad_();
    fresco::testing::PicturePart part(picture, fixture.camera, mask, mask);
    loss->evaluate(part).at(0).value.backward();
    CHECK(picture.grad().narrow(2, 30, 18).abs().max().item<double>() == 0);
    CHECK(picture.grad().narrow(2, 0, 24).abs().max().item<double>() > 0);

    const auto none = at::zeros({40, 48}, at::kBool);
    fresco::testing::PicturePart hidden(picture, fixture.camera, none, none);
    hidden.view_index = 1;
    CHECK(loss->evaluate(hidden).empty());
    fresco::testing::PicturePart tiny(at::zeros({3, 5, 48}), at::zeros({3, 5, 48}));
    tiny.view_index = 2;
    CHECK(loss->evaluate(tiny).empty());
}

TEST_CASE("A restored loss goes on with the same matches")
{
    Fixture fixture;
    const auto loss = fixture.make();
    fixture.evaluate(*loss, fixture.camera, 8, 0, 3);
    const auto state = loss->state();
    const auto other = waves(40, 48, 4);
    const double expected = fixture.evaluate(*loss, other, 9, 1, 3);

    const auto resumed = fixture.make();
    resumed->restore(state);
    CHECK(fixture.evaluate(*resumed, other, 9, 1, 3) == expected);
    const auto forgetful = fixture.make();
    CHECK(fixture.evaluate(*forgetful, other, 9, 1, 3) != expected);
    CHECK(fixture.make()->state().empty());
}

TEST_CASE("A style picture too small for three sizes of it is refused")
{
    Fixture fixture;
    fixture.context.style = {waves(20, 64, 3), waves(20, 64, 3)};
    CHECK_THROWS_WITH(fixture.make(), Catch::Contains("64 x 20; expected at least 28"));
}
