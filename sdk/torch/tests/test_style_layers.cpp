#include "catch.h"

#include <fresco/testing.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/testing.h>

#include <ATen/ops/ones.h>
#include <ATen/ops/zeros.h>

#include <memory>

using namespace fresco;

namespace
{

/// Something with these options, configured.
class Owner final : public Component
{
  public:
    explicit Owner(const std::string& json)
    {
        testing::TestFactory factory;
        factory.add("test.colors", [] { return std::make_shared<testing::ColorNetwork>(); });
        auto value = parse_json(json, "test");
        value.set("features", Value::Map{{"type", "test.colors"}});
        configure(value, factory);
    }
    StyleOptions options{this};
};

}  // namespace

TEST_CASE("layers of a style loss: the named ones, or the network's, each with its factor")
{
    CHECK((names_of(Owner("{}").options.compared("loss.x")) == std::vector<std::string>{"a"}));
    const Owner owner(R"({"layers": "b, a", "layer_weights": [2, 3]})");
    const auto named = owner.options.compared("loss.x");
    CHECK((names_of(named) == std::vector<std::string>{"b", "a"}));
    CHECK(named[1].factor == 3);
    CHECK((owner.options.needs({}).features.at(0).names == std::vector<std::string>{"b", "a"}));
    CHECK((Owner("{}").options.needs(named).features.at(0).names == std::vector<std::string>{"b", "a"}));
    CHECK_THROWS_WITH(Owner(R"({"layers": "d"})").options.compared("loss.x"), Contains("a, b"));
    CHECK_THROWS_WITH(Owner(R"({"layer_weights": [1, 2]})").options.compared("loss.x"),
                      Contains("loss.x: `layer_weights` has 2 entries for 1"));
    CHECK_THROWS_WITH(style_features(*owner.options.features, at::zeros({3, 4, 1}), named, "loss.x"),
                      Contains("1 x 4") && Contains("layer b"));
    const auto features = style_features(*owner.options.features, at::zeros({3, 4, 4}), named, "loss.x");
    CHECK((features[0].sizes() == at::IntArrayRef({3, 4}) && features[1].sizes() == at::IntArrayRef({3, 16})));
}

TEST_CASE("roles of a style picture")
{
    const StylePictures style{at::zeros({3, 1, 1}), at::ones({3, 2, 2})};
    CHECK(Owner("{}").options.roles(style).size() == 1);
    CHECK(Owner(R"({"targets": "coarse"})").options.roles(style).at(0).pixels == Pixels::all);
    const auto both = Owner(R"({"targets": "both"})").options.roles(style);
    REQUIRE(both.size() == 2);
    CHECK(both[0].picture.size(1) == 2);
    CHECK(both[1].pixels == Pixels::fine);
    CHECK(both[1].picture.size(1) == 1);
}
