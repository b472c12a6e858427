#include <fresco/testing.h>
#include <fresco/torch/testing.h>

#include <ATen/ATen.h>

#include "catch.h"

#include <memory>

namespace
{

std::unique_ptr<fresco::Loss> made(const fresco::Value& options, const torch::Tensor& style)
{
    auto loss = fresco::testing::make_from_plugin<fresco::Loss>(FRESCO_PLUGIN_FILE, "my.plugin");
    fresco::testing::TestFactory factory;
    loss->configure(options, factory);
    fresco::PrepareContext context;
    context.style = {style, style};
    loss->prepare(context);
    return loss;
}

torch::Tensor flat(double red, double green, double blue)
{
    return at::tensor({red, green, blue}, at::kDouble).view({3, 1, 1}).expand({3, 6, 8}).clone();
}

}  // namespace

TEST_CASE("the loss is the squared distance of the mean colors, and gradients lead there")
{
    const auto loss = made(fresco::Value::Map{}, flat(0.5, 0.25, 1));
    const auto picture = flat(0.25, 0.25, 0.5).set_requires_grad(true);
    fresco::testing::PicturePart part(picture, flat(0, 0, 0));
    const auto terms = loss->evaluate(part);
    REQUIRE(terms.size() == 1);
    CHECK(terms[0].value.item<double>() == Approx(0.25 * 0.25 + 0.5 * 0.5));
    terms[0].value.backward();
    // Each of the 48 pixels has 1/48 of 2 (0.25 - 0.5).
    CHECK(picture.grad()[0][3][3].item<double>() == Approx(-0.5 / 48));
    CHECK(picture.grad()[1].abs().max().item<double>() == Approx(0).margin(1e-12));
}

TEST_CASE("strength 0 asks for the camera picture's mean")
{
    const auto loss = made(fresco::Value::Map{{"strength", 0.0}}, flat(1, 1, 1));
    fresco::testing::PicturePart part(flat(0.25, 0.5, 0.75), flat(0.25, 0.5, 0.75));
    CHECK(loss->evaluate(part).at(0).value.item<double>() == Approx(0).margin(1e-12));
}

TEST_CASE("pixels outside the part do not count, and a part without pixels has no term")
{
    const auto loss = made(fresco::Value::Map{}, flat(0.5, 0.5, 0.5));
    auto half = at::ones({6, 8}, at::kBool);
    half.narrow(1, 4, 4).fill_(false);
    auto picture = flat(0.5, 0.5, 0.5);
    picture.narrow(2, 4, 4).fill_(1);
    fresco::testing::PicturePart part(picture, flat(0, 0, 0), half, half);
    CHECK(loss->evaluate(part).at(0).value.item<double>() == Approx(0).margin(1e-12));

    const auto none = at::zeros({6, 8}, at::kBool);
    fresco::testing::PicturePart empty(picture, picture, none, none);
    CHECK(loss->evaluate(empty).empty());
}
