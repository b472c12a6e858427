#include <fresco/torch/testing.h>

#include <ATen/ATen.h>

#include "catch.h"

#include <memory>

namespace
{

std::vector<fresco::LossTerm> evaluate(const std::string& options, fresco::Part& part)
{
    const auto loss = fresco::testing::loss_on_colors(FRESCO_PLUGIN_FILE, "loss.content", options);
    CHECK(loss->needs().features.at(0).camera);
    loss->prepare({});
    return loss->evaluate(part);
}

}  // namespace

TEST_CASE("loss.content is the mean square difference to the camera's features")
{
    auto picture = at::zeros({3, 4, 4}, at::kDouble);
    auto camera = at::zeros({3, 4, 4}, at::kDouble);
    camera[0].narrow(1, 0, 1).fill_(0.5);  // red 0.5 in the leftmost column
    fresco::testing::PicturePart part(picture, camera);
    SECTION("the layer meant for contents: 0.25 in one of three channels on half of the cells")
    {
        const auto terms = evaluate("{}", part);
        REQUIRE(terms.size() == 1);
        CHECK(terms[0].layer == "b");
        CHECK(terms[0].value.item<double>() == Approx(0.0625 / 6));
    }
    SECTION("a named layer")
    {
        CHECK(evaluate(R"({"layers": "a"})", part).at(0).value.item<double>() == Approx(0.25 / 12));
    }
    SECTION("only valid pixels count, and none gives no term")
    {
        auto mask = at::zeros({4, 4}, at::kBool);
        fresco::testing::PicturePart nothing(picture, camera, mask, mask);
        CHECK(evaluate("{}", nothing).empty());
        mask.narrow(1, 0, 2).fill_(true);
        fresco::testing::PicturePart left(picture, camera, mask, mask);
        CHECK(evaluate("{}", left).at(0).value.item<double>() == Approx(0.0625 / 3));
    }
    SECTION("an unknown layer is named with those there are")
    {
        CHECK_THROWS_WITH(evaluate(R"({"layers": "c"})", part), Catch::Contains("c") && Catch::Contains("a, b"));
    }
}

TEST_CASE("loss.content pulls only toward the camera picture")
{
    auto picture = at::full({3, 4, 4}, 0.25, at::kDouble).requires_grad_();
    const auto camera = at::full({3, 4, 4}, 0.75, at::kDouble).requires_grad_();
    fresco::testing::PicturePart part(picture, camera);
    evaluate(R"({"layers": "a"})", part).at(0).value.backward();
    CHECK(picture.grad().min().item<double>() == Approx(-2 * 0.5 / 48));
    CHECK_FALSE(camera.grad().defined());
}
