#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/testing.h>

#include <ATen/ATen.h>

#include <catch2/catch.hpp>

#include <memory>

namespace
{

/// Layer "a": the picture itself. Layer "b": its 2x2 averages. Only "a" is meant for styles.
class Colours final : public fresco::FeatureNetwork
{
  public:
    void prepare(const fresco::PrepareContext&) override {}
    std::vector<fresco::FeatureLayer> layers() const override
    {
        fresco::FeatureLayer a;
        a.name = "a";
        a.channels = 3;
        a.style = true;
        auto b = a;
        b.name = "b";
        b.stride = 2;
        b.style = false;
        return {a, b};
    }
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const override
    {
        std::vector<torch::Tensor> maps;
        for (const auto& name : names)
            maps.push_back(layer(name).stride == 1 ? picture : at::avg_pool2d(picture.unsqueeze(0), {2, 2}).squeeze(0));
        return maps;
    }
};

struct Fixture
{
    fresco::testing::TestFactory factory;
    fresco::Progress progress;
    fresco::PrepareContext context;

    Fixture()
    {
        factory.add("test.colours", [] { return std::make_shared<Colours>(); });
        // One fine size with two colours in equal parts, a coarse one that is all (0, 1, 0).
        context.style.fine = at::zeros({3, 2, 2}, at::kDouble);
        context.style.fine[0].fill_(1);
        context.style.fine[1][0].fill_(1);
        context.style.coarse = at::zeros({3, 4, 4}, at::kDouble);
        context.style.coarse[1].fill_(1);
        context.progress = &progress;
    }

    std::unique_ptr<fresco::Loss> make(const std::string& options)
    {
        auto value = fresco::parse_json(options, "test");
        value.set("features", fresco::Value::Map{{"type", "test.colours"}});
        auto made = fresco::testing::make_from_plugin(FRESCO_PLUGIN_FILE, "loss.gram");
        std::unique_ptr<fresco::Loss> loss(dynamic_cast<fresco::Loss*>(made.release()));
        loss->configure(value, factory);
        return loss;
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

TEST_CASE("loss.gram by hand", "[gram]")
{
    Fixture fixture;
    fresco::testing::PicturePart part(picture_of(1, 0, 0), picture_of(0, 0, 0));
    SECTION("centred: mean (1, 0.5, 0), covariance only 0.25 in the middle")
    {
        const auto terms = fixture.evaluate("{}", part);
        REQUIRE(terms.size() == 1);
        CHECK(terms[0].layer == "a");
        CHECK(terms[0].value.item<double>() == Approx(0.25 / 1.25 + 1));
    }
    SECTION("plain: Gram of the style is [1 .5 0; .5 .5 0; 0 0 0], ours [1 0 0; 0 0 0; 0 0 0]")
    {
        const auto terms = fixture.evaluate(R"({"centre": false})", part);
        CHECK(terms.at(0).value.item<double>() == Approx(0.75 / 9));
    }
    SECTION("coarse: Gram [0 0 0; 0 1 0; 0 0 0]")
    {
        const auto terms = fixture.evaluate(R"({"centre": false, "targets": "coarse"})", part);
        CHECK(terms.at(0).value.item<double>() == Approx(2.0 / 9));
    }
    SECTION("both, with a factor")
    {
        const auto terms =
            fixture.evaluate(R"({"centre": false, "targets": "both", "layers": "b, a", "layer_weights": [0, 10]})", part);
        REQUIRE(terms.size() == 2);
        CHECK(terms[0].value.item<double>() == Approx(0));
        CHECK(terms[1].layer == "a");
        CHECK(terms[1].value.item<double>() == Approx(27.5 / 9));
    }
}

TEST_CASE("loss.gram looks at the pixels of its role only", "[gram]")
{
    Fixture fixture;
    auto picture = picture_of(0, 1, 0);
    picture.narrow(2, 2, 2).fill_(1);
    auto all = at::ones({4, 4}, at::kBool);
    auto fine = at::zeros({4, 4}, at::kBool);
    fine.narrow(1, 0, 2).fill_(true);
    fresco::testing::PicturePart part(picture, picture, all, fine);
    SECTION("the coarse target is compared on all pixels: Gram [.5 .5 .5; .5 1 .5; .5 .5 .5]")
    {
        const auto terms = fixture.evaluate(R"({"centre": false, "targets": "coarse"})", part);
        CHECK(terms.at(0).value.item<double>() == Approx(8 * 0.25 / 9));
    }
    SECTION("the fine target on passing pixels: Gram [0 0 0; 0 1 0; 0 0 0]")
    {
        const auto terms = fixture.evaluate(R"({"centre": false})", part);
        CHECK(terms.at(0).value.item<double>() == Approx((1 + 0.25 * 3) / 9));
    }
    SECTION("no passing pixel leaves the coarse target alone; no pixel at all leaves nothing")
    {
        fresco::testing::PicturePart steep(picture, picture, all, at::zeros({4, 4}, at::kBool));
        CHECK(fixture.evaluate(R"({"centre": false, "targets": "both"})", steep).at(0).value.item<double>() ==
              Approx(8 * 0.25 / 9));
        CHECK(fixture.evaluate("{}", steep).empty());
        fresco::testing::PicturePart nothing(picture, picture, at::zeros({4, 4}, at::kBool), at::zeros({4, 4}, at::kBool));
        CHECK(fixture.evaluate(R"({"targets": "both"})", nothing).empty());
    }
}

TEST_CASE("loss.gram's errors and needs", "[gram]")
{
    Fixture fixture;
    CHECK_THROWS_WITH(fixture.make(R"({"layers": "a, c"})")->prepare(fixture.context),
                      Catch::Contains("c") && Catch::Contains("a, b"));
    CHECK_THROWS_WITH(fixture.make(R"({"layer_weights": [1, 2]})")->prepare(fixture.context), Catch::Contains("layer_weights"));
    fixture.context.style.fine = at::zeros({3, 1, 1}, at::kDouble);
    CHECK_THROWS_WITH(fixture.make(R"({"layers": "b"})")->prepare(fixture.context), Catch::Contains("too small"));

    auto loss = fixture.make("{}");
    CHECK(loss->needs().features.at(0).names.empty());
    loss->prepare(Fixture().context);
    CHECK(loss->needs().features.at(0).names == std::vector<std::string>{"a"});
    CHECK_FALSE(loss->needs().picture);
    CHECK(loss->state().empty());
}
