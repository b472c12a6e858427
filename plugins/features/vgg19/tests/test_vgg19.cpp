#include "random_layers.h"
#include "vgg19.h"

#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <torch/csrc/autograd/autograd.h>

#include "catch.h"

#include <algorithm>
#include <cmath>
#include <far_device.h>
#include <functional>
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
    CHECK(layers[0].name == "relu1_1");
    CHECK(layers[0].margin_px == 1);
    CHECK(layers[1].margin_px == 2);
    CHECK(layers[2].name == "relu2_1");
    CHECK(layers[2].stride == 2);
    CHECK(layers[2].margin_px == 4);
    CHECK(layers[2].channels == 128);
    CHECK((layers[0].style && !layers[1].style && layers[2].style));
    CHECK((!layers[0].content && !layers[1].content && layers[2].content));
    CHECK(network.encode(noise_picture(1, 1), {"relu2_1"}).at(0).sizes() == at::IntArrayRef({128, 0, 0}));
    CHECK(network.encode(noise_picture(3, 5), {"relu2_1"}).at(0).sizes() == at::IntArrayRef({128, 1, 2}));
}

namespace
{

/// The component with these weights and options, prepared on `context`.
std::shared_ptr<fresco::FeatureNetwork> prepared(const fresco::SafeTensors& contents, const fresco::PrepareContext& context,
                                                 const fresco::Value::Map& options = {})
{
    const fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "weights.safetensors";
    fresco::write_safetensors(file, contents);
    auto network = fresco::testing::make_from_plugin<fresco::FeatureNetwork>(FRESCO_PLUGIN_FILE, "features.vgg19");
    fresco::testing::TestFactory factory;
    fresco::Value::Map config{{"weights", file.string()}};
    config.insert(config.end(), options.begin(), options.end());
    network->configure(config, factory);
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

    contents.metadata["normalized"] = "unit mean activation";
    CHECK(mean_over_pictures(*prepared(contents, context), "relu2_1") == Approx(83).epsilon(1e-5));
    CHECK(at::equal(prepared(raw, context)->encode(noise_picture(8, 8), {"relu2_1"})[0], b));

    CHECK_THROWS_WITH(prepared(three_layers(), {}), Catch::Contains("no picture"));
    contents = three_layers();
    contents.tensors["features.2.weight"].zero_();
    contents.tensors["features.2.bias"].fill_(-1);
    CHECK_THROWS_WITH(prepared(contents, context), Catch::Contains("relu1_2 is zero"));
}

TEST_CASE("features.vgg19 as a component")
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

    fresco::testing::TestFactory factory;
    network->configure(fresco::Value::Map{{"weights", "/none"}}, factory);
    CHECK_THROWS_AS(network->prepare({}), fresco::MissingInput);
}

namespace
{

const std::vector<std::string> names{"relu1_1", "relu2_1", "relu3_1"};

/// A sum of mean squares of Gram matrices' differences, and its gradient by the picture.
std::pair<double, torch::Tensor> style_loss(const std::function<std::vector<torch::Tensor>(const torch::Tensor&)>& encode,
                                            const torch::Tensor& picture, const torch::Tensor& style)
{
    const auto gram = [](const torch::Tensor& maps)
    {
        const auto features = maps.flatten(1);
        return features.mm(features.t()) / features.size(1);
    };
    const auto input = picture.clone().set_requires_grad(true);
    const auto shown = encode(input);
    const auto wanted = encode(style);
    torch::Tensor sum;
    for (std::size_t i = 0; i < shown.size(); ++i)
    {
        const auto target = gram(wanted[i]).detach();
        const auto term = (gram(shown[i]) - target).pow(2).mean() / target.pow(2).mean();
        sum = sum.defined() ? sum + term : term;
    }
    return {sum.item<double>(), torch::autograd::grad({sum}, {input})[0].cpu()};
}

/// The maps of `names` by PyTorch's own functions and their gradients, and by the published means and deviations.
std::vector<torch::Tensor> plainly_encoded(const std::vector<vgg19::Convolution>& layers, bool caffe, bool reflect,
                                           const torch::Tensor& picture)
{
    const auto of_channels = [](std::vector<double> values) { return at::tensor(values, at::kDouble).view({3, 1, 1}); };
    auto maps = caffe ? picture.flip(0) * 255 - of_channels({103.939, 116.779, 123.68})
                      : (picture - of_channels({0.485, 0.456, 0.406})) / of_channels({0.229, 0.224, 0.225});
    maps = maps.unsqueeze(0);
    std::vector<torch::Tensor> result;
    for (const auto& layer : layers)
    {
        maps = layer.pooled ? at::max_pool2d(maps, {2, 2}) : maps;
        maps = reflect ? at::reflection_pad2d(maps, {1, 1, 1, 1}) : maps;
        maps = at::relu(at::conv2d(maps, layer.weights.to(at::kDouble), layer.bias.to(at::kDouble), 1, reflect ? 0 : 1));
        if (std::ranges::find(names, layer.layer) != names.end())
            result.push_back(maps.squeeze(0));
    }
    return result;
}

double cosine(const torch::Tensor& a, const torch::Tensor& b)
{
    return ((a * b).sum() / (a.norm() * b.norm())).item<double>();
}

}  // namespace

TEST_CASE("reflected borders are libtorch's, forward and back, and leave the channels innermost")
{
    for (const auto& [height, width] : {std::pair<std::int64_t, std::int64_t>{5, 7}, {2, 3}, {1, 4}, {3, 1}})
    {
        CAPTURE(height, width);
        const auto maps = at::randn({1, 4, height, width}, at::kDouble).contiguous(at::MemoryFormat::ChannelsLast);
        const auto factor = at::randn({1, 4, height + 2, width + 2}, at::kDouble);
        const auto a = maps.clone().set_requires_grad(true);
        const auto b = maps.clone().set_requires_grad(true);
        const auto own = vgg19::reflected(a);
        const auto rows = height > 1 ? at::reflection_pad2d(b, {0, 0, 1, 1}) : at::replication_pad2d(b, {0, 0, 1, 1});
        const auto other = width > 1 ? at::reflection_pad2d(rows, {1, 1, 0, 0}) : at::replication_pad2d(rows, {1, 1, 0, 0});
        CHECK(own.is_contiguous(at::MemoryFormat::ChannelsLast));
        CHECK(own.equal(other));
        CHECK(torch::autograd::grad({(own * factor).sum()}, {a})[0].allclose(
            torch::autograd::grad({(other * factor).sum()}, {b})[0], 1e-12, 1e-12));
    }
}

TEST_CASE("libtorch's convolutions, with channels innermost, agree with another device")
{
    const auto picture = at::rand({3, 22, 31});
    const auto style = at::rand({3, 26, 18});
    for (const bool caffe : {false, true})
    {
        const auto input = caffe ? fresco::weights::caffe_input() : fresco::weights::torchvision_input();
        vgg19::Vgg19 network(random_layers(), input);
        for (const auto& maps : network.encode_generally(picture, names))
            CHECK(maps.flatten(1).t().is_contiguous());
        const auto near = style_loss([&](const auto& p) { return network.encode_generally(p, names); }, picture, style);
        network.move_to(fresco::testing::far_device());
        const auto far_picture = picture.to(fresco::testing::far_device());
        fresco::testing::forget_far_traffic();
        network.encode(far_picture, names);
        CHECK(fresco::testing::far_traffic().wait_count() == 0);
        const auto far =
            style_loss([&](const auto& p) { return network.encode(p, names); }, far_picture, style.to(far_picture.device()));
        CHECK(far.first == Approx(near.first).epsilon(1e-5));
        CHECK(cosine(far.second, near.second) > 0.99999);
    }
}

TEST_CASE("the maps and a convolution's way back, by the turned filters, are libtorch's own, with both inputs and paddings")
{
    for (const bool caffe : {false, true})
        for (const bool reflect : {false, true})
        {
            CAPTURE(caffe, reflect);
            auto input = caffe ? fresco::weights::caffe_input() : fresco::weights::torchvision_input();
            CHECK(input.padding == fresco::weights::Vgg19Padding::zero);
            if (reflect)
                input.padding = fresco::weights::Vgg19Padding::reflect;
            const auto layers = random_layers();
            const vgg19::Vgg19 network(layers, input);
            const auto picture = at::rand({3, 22, 31}, at::kDouble);
            const auto style = at::rand({3, 26, 18}, at::kDouble);
            const auto own = style_loss([&](const auto& p) { return network.encode_generally(p, names); }, picture, style);
            const auto other =
                style_loss([&](const auto& p) { return plainly_encoded(layers, caffe, reflect, p); }, picture, style);
            CHECK(own.first == Approx(other.first).epsilon(1e-12));
            CHECK(own.second.allclose(other.second, 1e-9, 1e-14));
        }
}

TEST_CASE("precisions that the device lacks are refused")
{
    CHECK_THROWS_WITH(prepared(three_layers(), pictures(), {{"precision", "tf32"}}), Catch::Contains("CUDA"));
}

TEST_CASE("The scale of the raw network's layers is that of its published activations")
{
    const std::vector<std::pair<const char*, double>> published{{"relu1_1", 21},  {"relu2_1", 83}, {"relu3_1", 76},
                                                                {"relu4_1", 320}, {"relu5_1", 27}, {"relu4_2", 390}};
    for (const auto& [layer, mean] : published)
        CHECK(vgg19::raw_mean(layer) == mean);
    CHECK(vgg19::raw_mean("relu1_2") == 21);
}
