#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/features.h>

#include <ATen/ATen.h>

#include "catch.h"

#include <memory>

namespace
{

std::unique_ptr<fresco::FeatureNetwork> made(double contrast)
{
    auto network = fresco::testing::make_from_plugin<fresco::FeatureNetwork>(FRESCO_PLUGIN_FILE, "my.plugin");
    fresco::testing::TestFactory factory;
    network->configure(fresco::Value::Map{{"contrast", contrast}}, factory);
    network->prepare({});
    return network;
}

}  // namespace

TEST_CASE("features of a ramp are its slope")
{
    const auto network = made(2);
    // 0.01 a column, 0.03 a row.
    const auto picture =
        (0.01 * at::arange(16, at::kDouble).view({1, 1, 16}) + 0.03 * at::arange(12, at::kDouble).view({1, 12, 1}))
            .expand({3, 12, 16})
            .clone();
    const auto features = network->encode(picture, {"shapes", "edges"});
    REQUIRE(features.size() == 2);
    CHECK(features[1].sizes() == at::IntArrayRef({6, 12, 16}));
    CHECK(features[1][0][5][5].item<double>() == Approx(0.02));
    CHECK(features[1][3][5][5].item<double>() == Approx(0.06));
    CHECK(features[1][0][5][15].item<double>() == Approx(0).margin(1e-12));  // At the border there is nothing on the right.
    CHECK(features[0].sizes() == at::IntArrayRef({6, 3, 4}));
    CHECK(features[0][0][1][1].item<double>() == Approx(0.02));
}

TEST_CASE("features of a crop are those of the whole picture, but for the margin")
{
    const auto network = made(1);
    const auto picture = at::sin(at::arange(3 * 16 * 20, at::kDouble)).view({3, 16, 20});
    const auto whole = network->encode(picture, {"shapes"})[0];
    const auto crop = network->encode(picture.narrow(2, 4, 12), {"shapes"})[0];
    // Whole cells of stride 4; the last column looks over the crop's border.
    CHECK(at::allclose(crop.narrow(2, 0, 2), whole.narrow(2, 1, 2)));
}

TEST_CASE("gradients flow, and an unknown layer is named")
{
    const auto network = made(1);
    const auto picture = at::rand({3, 8, 8}, at::kDouble).set_requires_grad(true);
    network->encode(picture, {"edges"})[0].square().sum().backward();
    CHECK(picture.grad().abs().max().item<double>() > 0);
    CHECK_THROWS_AS(network->encode(picture, {"relu1_1"}), fresco::Error);
}
