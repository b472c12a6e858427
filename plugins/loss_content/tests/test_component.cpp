#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/testing.h>

#include <ATen/ATen.h>

#include "catch.h"

#include <memory>

namespace
{

/// Layer "x1": the picture; layer "x2": its 2x2 averages, twice as large in value, meant for contents.
class Averages final : public fresco::FeatureNetwork
{
  public:
    void prepare(const fresco::PrepareContext&) override {}
    std::vector<fresco::FeatureLayer> layers() const override
    {
        fresco::FeatureLayer one;
        one.name = "x1";
        one.channels = 3;
        auto two = one;
        two.name = "x2";
        two.stride = 2;
        two.content = true;
        return {one, two};
    }
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const override
    {
        std::vector<torch::Tensor> maps;
        for (const auto& name : names)
            maps.push_back(layer(name).stride == 1 ? picture : at::avg_pool2d(picture.unsqueeze(0), {2, 2}).squeeze(0) * 2);
        return maps;
    }
};

std::vector<fresco::LossTerm> evaluate(const std::string& options, fresco::Part& part)
{
    fresco::testing::TestFactory factory;
    factory.add("test.averages", [] { return std::make_shared<Averages>(); });
    auto value = fresco::parse_json(options, "test");
    value.set("features", fresco::Value::Map{{"type", "test.averages"}});
    const auto loss = fresco::testing::make_from_plugin<fresco::Loss>(FRESCO_PLUGIN_FILE, "loss.content");
    loss->configure(value, factory);
    CHECK(loss->needs().features.at(0).camera);
    loss->prepare({});
    return loss->evaluate(part);
}

}  // namespace

TEST_CASE("loss.content is the mean square difference to the camera's features")
{
    auto picture = at::zeros({3, 4, 4}, at::kDouble);
    auto camera = at::zeros({3, 4, 4}, at::kDouble);
    camera[0].narrow(1, 0, 2).fill_(0.5);  // red 0.5 in the left half
    fresco::testing::PicturePart part(picture, camera);
    SECTION("the layer meant for contents: 1 in one of three channels on half of the cells")
    {
        const auto terms = evaluate("{}", part);
        REQUIRE(terms.size() == 1);
        CHECK(terms[0].layer == "x2");
        CHECK(terms[0].value.item<double>() == Approx(1.0 / 6));
    }
    SECTION("a named layer")
    {
        CHECK(evaluate(R"({"layers": "x1"})", part).at(0).value.item<double>() == Approx(0.25 / 6));
    }
    SECTION("relative to the camera's features: nothing of them is there; without any, 1 is the unit")
    {
        CHECK(evaluate(R"({"relative": true})", part).at(0).value.item<double>() == Approx(1));
        fresco::testing::PicturePart dark(camera, picture);
        CHECK(evaluate(R"({"relative": true})", dark).at(0).value.item<double>() == Approx(1.0 / 6));
    }
    SECTION("only valid pixels count, and none gives no term")
    {
        auto mask = at::zeros({4, 4}, at::kBool);
        CHECK(evaluate("{}", *std::make_unique<fresco::testing::PicturePart>(picture, camera, mask, mask)).empty());
        mask.narrow(1, 0, 2).fill_(true);
        CHECK(evaluate("{}", *std::make_unique<fresco::testing::PicturePart>(picture, camera, mask, mask))
                  .at(0)
                  .value.item<double>() == Approx(1.0 / 3));
    }
    SECTION("an unknown layer is named with those there are")
    {
        CHECK_THROWS_WITH(evaluate(R"({"layers": "x3"})", part), Catch::Contains("x3") && Catch::Contains("x1, x2"));
    }
}

TEST_CASE("loss.content pulls only toward the camera picture")
{
    auto picture = at::full({3, 4, 4}, 0.25, at::kDouble).requires_grad_();
    const auto camera = at::full({3, 4, 4}, 0.75, at::kDouble).requires_grad_();
    fresco::testing::PicturePart part(picture, camera);
    evaluate(R"({"layers": "x1"})", part).at(0).value.backward();
    CHECK(picture.grad().min().item<double>() == Approx(-2 * 0.5 / 48));
    CHECK_FALSE(camera.grad().defined());
}
