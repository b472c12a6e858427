#include <fresco/testing.h>
#include <fresco/torch/testing.h>

#include <ATen/ATen.h>

#include <catch2/catch.hpp>

#include <memory>

namespace
{

/// Grey bars of 8 px, between `dark` and `light`.
torch::Tensor bars(double dark, double light)
{
    auto picture = at::full({3, 32, 48}, dark, at::kDouble);
    for (std::int64_t x = 0; x < 48; x += 16)
        picture.narrow(2, x, 8).fill_(light);
    return picture;
}

std::unique_ptr<fresco::Loss> prepared(const torch::Tensor& camera, const torch::Tensor& style)
{
    auto made = fresco::testing::make_from_plugin(FRESCO_PLUGIN_FILE, "loss.content_gradients");
    std::unique_ptr<fresco::Loss> loss(dynamic_cast<fresco::Loss*>(made.release()));
    fresco::PrepareContext context;
    context.style = {style, style};
    context.camera_samples = {camera};
    loss->prepare(context);
    return loss;
}

double value(fresco::Loss& loss, const torch::Tensor& picture, const torch::Tensor& camera)
{
    fresco::testing::PicturePart part(picture, camera);
    return loss.evaluate(part).at(0).value.item<double>();
}

}  // namespace

TEST_CASE("The recoloured camera picture is what loss.content_gradients asks for")
{
    // The style is grey too, from 0.1 to 0.9: the recolouring stretches 0.3..0.7 to it.
    const auto camera = bars(0.3, 0.7);
    const auto loss = prepared(camera, bars(0.1, 0.9));
    CHECK(loss->needs().picture);
    const double at_target = value(*loss, bars(0.1, 0.9), camera);
    const double at_camera = value(*loss, camera, camera);
    const double inverted = value(*loss, bars(0.9, 0.1), camera);
    CHECK(at_target == Approx(0).margin(1e-3));
    CHECK(at_camera > 0.1);
    CHECK(inverted > 2 * at_camera);
}

TEST_CASE("loss.content_gradients without valid pixels has no term, and flat pictures give finite values")
{
    const auto camera = bars(0.3, 0.7);
    const auto loss = prepared(camera, bars(0.1, 0.9));
    const auto none = at::zeros({32, 48}, at::kBool);
    fresco::testing::PicturePart hidden(camera, camera, none, none);
    CHECK(loss->evaluate(hidden).empty());

    const auto flat = at::full({3, 32, 48}, 0.5, at::kDouble);
    CHECK(value(*prepared(flat, flat), camera, flat) < 1e6);
}

TEST_CASE("Invalid pixels do not enter loss.content_gradients")
{
    const auto camera = bars(0.3, 0.7);
    const auto loss = prepared(camera, bars(0.1, 0.9));
    auto mask = at::ones({32, 48}, at::kBool);
    mask.narrow(1, 24, 24).fill_(false);
    const auto run = [&](double beyond)
    {
        auto picture = camera.clone();
        auto seen = camera.clone();
        picture.narrow(2, 24, 24).fill_(beyond);
        seen.narrow(2, 24, 24).fill_(1 - beyond);
        fresco::testing::PicturePart part(picture, seen, mask, mask);
        return loss->evaluate(part).at(0).value.item<double>();
    };
    CHECK(run(0.0) == Approx(run(1.0)));
}
