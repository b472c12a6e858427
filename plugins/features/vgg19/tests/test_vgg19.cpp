#include "plugin_under_test.h"
#include "random_layers.h"
#include "vgg19.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include "catch.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace
{

void add(fresco::SafeTensors& contents, const std::string& key, std::int64_t outputs, std::int64_t inputs)
{
    using fresco::testing::random_tensor;
    contents.tensors[key + ".weight"] = random_tensor({outputs, inputs, 3, 3}, 1) / std::sqrt(static_cast<double>(inputs));
    contents.tensors[key + ".bias"] = random_tensor({outputs}, 2) * 0.1;
}

/// conv1_1 .. conv2_1 under torchvision's keys.
fresco::SafeTensors three_layers()
{
    fresco::SafeTensors contents;
    add(contents, "features.0", 64, 3);
    add(contents, "features.2", 64, 64);
    add(contents, "features.5", 128, 64);
    return contents;
}

/// As a plugin reads them from a file.
std::vector<vgg19::Convolution> layers_of(const fresco::SafeTensors& contents)
{
    const fresco::testing::TemporaryFolder folder;
    fresco::write_safetensors(folder.path() / "w", contents);
    const auto file = fresco::weights::read_weights(folder.path() / "w");
    return vgg19::convolutions(fresco::weights::recognize_vgg19(file.contents, "w"), "w");
}

torch::Tensor noise_picture(std::int64_t height, std::int64_t width)
{
    return fresco::testing::random_tensor({3, height, width}, 3) + 0.5;
}

}  // namespace

TEST_CASE("Layers: stride, channels, reach, and the defaults for style and content")
{
    const vgg19::Vgg19 network(layers_of(three_layers()), {});
    const auto layers = network.layers();
    REQUIRE(layers.size() == 3);
    CHECK((layers[0].name == "relu1_1" && layers[0].margin_px == 1 && layers[1].margin_px == 2));
    CHECK((layers[2].name == "relu2_1" && layers[2].stride == 2 && layers[2].margin_px == 4 && layers[2].channels == 128));
    CHECK((layers[0].style && !layers[1].style && layers[2].style));
    CHECK((!layers[0].content && !layers[1].content && layers[2].content));
    CHECK(network.encode(noise_picture(1, 1), {"relu2_1"}).at(0).sizes() == at::IntArrayRef({128, 0, 0}));
    CHECK(network.encode(noise_picture(3, 5), {"relu2_1"}).at(0).sizes() == at::IntArrayRef({128, 1, 2}));
}

namespace
{

/// The component with these weights and options, prepared on `context`.
std::shared_ptr<fresco::FeatureNetwork> prepared(const fresco::SafeTensors& contents, const fresco::PrepareContext& context,
                                                 fresco::Value::Map options = {})
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "weights.safetensors";
    fresco::write_safetensors(file, contents);
    options.emplace_back("weights", file.string());
    auto network = fresco::testing::configured<fresco::FeatureNetwork>("features.vgg19", options);
    network->prepare(context);
    return network;
}

fresco::PrepareContext pictures()
{
    fresco::PrepareContext context;
    context.style.fine = noise_picture(24, 20);
    context.camera_samples = {noise_picture(16, 24) * 0.5, 1 - noise_picture(14, 18)};
    return context;
}

}  // namespace

TEST_CASE("Weights on another scale get the raw means on style and frames")
{
    auto context = pictures();
    std::vector<std::string> said;
    context.message = [&](const std::string& text) { said.push_back(text); };
    const auto mean_over_pictures = [&](const fresco::FeatureNetwork& network, const char* layer)
    {
        double sum = network.encode(context.style.fine, {layer})[0].to(at::kDouble).mean().item<double>();
        for (const auto& sample : context.camera_samples)
            sum += network.encode(sample, {layer})[0].to(at::kDouble).mean().item<double>();
        return sum / 3;
    };
    auto contents = three_layers();
    const auto rescaled = prepared(contents, context);
    for (const char* layer : {"relu1_1", "relu1_2", "relu2_1"})
        CHECK(mean_over_pictures(*rescaled, layer) == Approx(layer == std::string("relu2_1") ? 83 : 21).epsilon(1e-5));
    REQUIRE(said.size() == 1);
    CHECK_THAT(said.front(), Catch::Contains("relu1_2") && Catch::Contains(" to 21") && Catch::Contains(" to 83"));
    // Zero padding stands for the mean color in both, so the features differ only by a factor, also at the border.
    auto raw = contents;
    raw.metadata = {{"scale", "raw"}};
    const auto plain = prepared(raw, {});
    const auto a = rescaled->encode(noise_picture(8, 8), {"relu2_1"})[0];
    const auto b = plain->encode(noise_picture(8, 8), {"relu2_1"})[0];
    CHECK(at::allclose(a, b * (83 / mean_over_pictures(*plain, "relu2_1")), 1e-4, 5e-3));

    contents.metadata["scale"] = "other";
    CHECK(mean_over_pictures(*prepared(contents, context), "relu2_1") == Approx(83).epsilon(1e-5));
    CHECK(at::equal(prepared(raw, context)->encode(noise_picture(8, 8), {"relu2_1"})[0], b));

    CHECK_THROWS_WITH(prepared(three_layers(), {}), Catch::Contains("no picture"));
    contents = three_layers();
    contents.tensors["features.2.weight"].zero_();
    contents.tensors["features.2.bias"].fill_(-1);
    CHECK_THROWS_WITH(prepared(contents, context), Catch::Contains("relu1_2 is zero"));
}

TEST_CASE("features.vgg19 as a component: layers, weights and precisions that it lacks are refused")
{
    auto contents = three_layers();
    const auto network = prepared(contents, pictures());
    CHECK(network->encode(noise_picture(8, 8), {"relu2_1"}).at(0).sizes() == at::IntArrayRef({128, 4, 4}));
    CHECK_THROWS_WITH(network->encode(noise_picture(8, 8), {"relu3_1"}),
                      Catch::Contains("relu3_1") && Catch::Contains("relu2_1"));

    contents.tensors["features.0.bias"][3] = std::nanf("");
    CHECK_THROWS_WITH(prepared(contents, pictures()), Catch::Contains("features.0.bias") && Catch::Contains("finite"));
    contents.tensors["features.0.weight"] = at::zeros({64, 3, 5, 5});
    CHECK_THROWS_WITH(prepared(contents, pictures()), Catch::Contains("features.0.weight") && Catch::Contains("64 x 3 x 5 x 5"));

    CHECK_THROWS_WITH(prepared(three_layers(), pictures(), {{"precision", "tf32"}}), Catch::Contains("CUDA"));

    const auto absent =
        fresco::testing::configured<fresco::FeatureNetwork>("features.vgg19", fresco::Value::Map{{"weights", "/none"}});
    CHECK_THROWS_AS(absent->prepare({}), fresco::MissingInput);
}

TEST_CASE("The scale of the raw network's layers is that of its published activations")
{
    const std::vector<std::pair<const char*, double>> published{{"relu1_1", 21},  {"relu2_1", 83}, {"relu3_1", 76},
                                                                {"relu4_1", 320}, {"relu5_1", 27}, {"relu4_2", 390}};
    for (const auto& [layer, mean] : published)
        CHECK(vgg19::raw_mean(layer) == mean);
    CHECK(vgg19::raw_mean("relu1_2") == 21);
}
