#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/testing.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include "catch.h"

#include <cmath>
#include <memory>

namespace
{

torch::Tensor waves(std::int64_t height, std::int64_t width, double period)
{
    auto picture = at::empty({3, height, width}, at::kFloat);
    float* out = picture.data_ptr<float>();
    for (std::int64_t c = 0; c < 3; ++c)
        for (std::int64_t y = 0; y < height; ++y)
            for (std::int64_t x = 0; x < width; ++x)
                *out++ =
                    static_cast<float>(0.5 + 0.4 * std::sin((static_cast<double>(x + 2 * y)) / period + static_cast<double>(c)));
    return picture;
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
    const auto loss = fixture.make(R"({"refresh_steps": 4, "scales": 1})");
    const auto other = waves(40, 48, 4);
    fixture.evaluate(*loss, fixture.camera, 0, 0);
    const auto fresh = [&](const torch::Tensor& picture)
    {
        const auto anew = fixture.make(R"({"refresh_steps": 4, "scales": 1})");
        return fixture.evaluate(*anew, picture, 0, 0);
    };
    const double kept = fixture.evaluate(*loss, other, 1, 1);
    CHECK(kept > fresh(other));
    CHECK(fixture.evaluate(*loss, other, 4, 4) == fresh(other));
    // A rule that evaluates twice in one step sees one function.
    CHECK(fixture.evaluate(*loss, fixture.camera, 4, 4) > fresh(fixture.camera));
    // Another view is searched at once, whatever its count.
    CHECK(fixture.evaluate(*loss, fixture.camera, 5, 1, 1) == fresh(fixture.camera));
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

    auto damaged = state;
    damaged.erase("view");
    CHECK_THROWS_WITH(resumed->restore(damaged), Catch::Contains("view"));
    damaged = state;
    damaged["level0.scale0"] = damaged["level0.scale0"] + 1'000'000;
    CHECK_THROWS_WITH(resumed->restore(damaged), Catch::Contains("another style"));
    damaged = state;
    damaged["level0.scale0"] = at::zeros({3}, at::kInt);
    resumed->restore(damaged);
    CHECK_THROWS_WITH(fixture.evaluate(*resumed, other, 9, 1, 3), Catch::Contains("another size"));
}

TEST_CASE("A style picture too small for the scales is refused")
{
    Fixture fixture;
    fixture.context.style = {waves(20, 64, 3), waves(20, 64, 3)};
    CHECK_THROWS_WITH(fixture.make(), Catch::Contains("64 x 20") && Catch::Contains("scales"));
}
