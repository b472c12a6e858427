#include "reflected.h"
#include "shared_data.h"
#include "vgg19.h"

#include <far_device.h>
#include <fresco/error.h>
#include <fresco/testing.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <torch/csrc/autograd/autograd.h>

#include "catch.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace
{

/// Layers drawn so that activations keep their size, up to relu3_1.
std::vector<vgg19::Convolution> random_layers()
{
    at::manual_seed(3);
    std::vector<vgg19::Convolution> layers;
    std::int64_t inputs = 3;
    const auto add = [&](const char* name, std::int64_t outputs, bool pooled)
    {
        const double deviation = std::sqrt(2.0 / (9.0 * static_cast<double>(inputs)));
        layers.push_back({name, at::randn({outputs, inputs, 3, 3}) * deviation, at::randn({outputs}) * 0.1, pooled});
        inputs = outputs;
    };
    add("relu1_1", 64, false);
    add("relu1_2", 64, false);
    add("relu2_1", 128, true);
    add("relu2_2", 128, false);
    add("relu3_1", 256, true);
    return layers;
}

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

TEST_CASE("libtorch's convolutions, with channels innermost, agree with minimal filtering and with another device")
{
    const auto picture = at::rand({3, 22, 31});
    const auto style = at::rand({3, 26, 18});
    for (const bool caffe : {false, true})
    {
        const auto input = caffe ? fresco::weights::caffe_input() : fresco::weights::torchvision_input();
        vgg19::Vgg19 network(random_layers(), input, vgg19::Pooling::max);
        const auto fast = network.encode(picture, names);
        const auto general = network.encode_generally(picture, names);
        for (std::size_t i = 0; i < names.size(); ++i)
        {
            CHECK(general[i].allclose(fast[i], 1e-3, 1e-3));
            CHECK(general[i].flatten(1).t().is_contiguous());
        }
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

TEST_CASE("mixed precision changes a style loss by less than 1 % and hardly turns its gradient")
{
    if (!vgg19::convolves_bfloat16(torch::kCPU))
    {
        skipped("mixed precision: libtorch convolves no bfloat16 on this processor");
        return;
    }
    at::manual_seed(7);
    const auto noise = at::rand({3, 40, 56});
    const auto picture = at::avg_pool2d(noise.unsqueeze(0), {3, 3}, {1, 1}, {1, 1}).squeeze(0);
    const auto style = at::avg_pool2d(at::rand({3, 48, 48}).unsqueeze(0), {5, 5}, {1, 1}, {2, 2}).squeeze(0);
    for (const auto pooling : {vgg19::Pooling::max, vgg19::Pooling::average})
        for (const bool caffe : {false, true})
        {
            vgg19::Vgg19 network(random_layers(), caffe ? fresco::weights::caffe_input() : fresco::weights::torchvision_input(),
                                 pooling);
            const auto encode = [&](const auto& p) { return network.encode_generally(p, names); };
            const auto full = style_loss(encode, picture, style);
            network.set_precision(vgg19::Precision::mixed);
            const auto maps = encode(picture);
            CHECK(maps[2].scalar_type() == at::kFloat);
            const auto mixed = style_loss(encode, picture, style);
            CHECK(mixed.second.scalar_type() == at::kFloat);
            CHECK(mixed.first == Approx(full.first).epsilon(0.01));
            CHECK(cosine(mixed.second, full.second) > 0.99);
            // It is not the same after all.
            CHECK_FALSE(mixed.second.equal(full.second));
            CHECK(encode(picture.to(at::kDouble))[2].scalar_type() == at::kDouble);
        }
}

TEST_CASE("mixed precision is refused where it would have no effect")
{
    const fresco::testing::TemporaryFolder folder;
    fresco::SafeTensors contents;
    contents.tensors["conv1_1.weight"] = at::ones({64, 3, 3, 3});
    contents.tensors["conv1_1.bias"] = at::ones({64});
    fresco::write_safetensors(folder.path() / "w", contents);
    fresco::testing::TestFactory factory;
    const auto prepare = [&](const std::string& convolutions)
    {
        auto object = fresco::testing::make_from_plugin(FRESCO_PLUGIN_FILE, "features.vgg19");
        object->configure(fresco::Value::Map{{"weights", (folder.path() / "w").string()},
                                             {"precision", "mixed"},
                                             {"convolutions", convolutions},
                                             {"rescale", false}},
                          factory);
        fresco::PrepareContext context;
        context.style.fine = at::rand({3, 16, 16});
        dynamic_cast<fresco::FeatureNetwork&>(*object).prepare(context);
    };
    CHECK_THROWS_WITH(prepare("auto"), Catch::Contains("precision: mixed") && Catch::Contains("convolutions: libtorch"));
    if (vgg19::convolves_bfloat16(torch::kCPU))
        CHECK_NOTHROW(prepare("libtorch"));
    else
        CHECK_THROWS_WITH(prepare("libtorch"), Catch::Contains("bfloat16") && Catch::Contains("precision: full"));
}

TEST_CASE("how maps lie in memory changes neither features nor gradients")
{
    for (const auto padding : {fresco::weights::Vgg19Padding::reflect, fresco::weights::Vgg19Padding::zero})
    {
        auto input = fresco::weights::caffe_input();
        input.padding = padding;
        const vgg19::Vgg19 network(random_layers(), input, vgg19::Pooling::average);
        // Of the last layer's maps, a side of the second picture has one pixel.
        for (const auto& [height, width] : {std::pair{27, 34}, {6, 21}})
        {
            CAPTURE(height);
            const auto picture = at::rand({3, height, width}, at::kDouble);
            const auto [gradient, features] = [&]
            {
                std::vector<torch::Tensor> gradients;
                std::vector<std::vector<torch::Tensor>> all;
                for (const auto order : {vgg19::Order::channels_innermost, vgg19::Order::channels_outermost})
                {
                    const auto shown = picture.clone().set_requires_grad(true);
                    all.push_back(network.encode_generally(shown, names, order));
                    (all.back()[0].square().sum() + all.back()[2].square().sum()).backward();
                    gradients.push_back(shown.grad());
                }
                return std::pair(gradients, all);
            }();
            for (std::size_t i = 0; i < names.size(); ++i)
                CHECK(at::allclose(features[0][i], features[1][i], 1e-10, 1e-10));
            CHECK(at::allclose(gradient[0], gradient[1], 1e-10, 1e-10));
        }
    }
}
