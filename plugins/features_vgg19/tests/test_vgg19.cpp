#include "shared_data.h"
#include "vgg19.h"

#include <fresco/error.h>
#include <fresco/testing.h>

#include <ATen/ATen.h>
#include <ATen/Parallel.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <memory>

namespace
{

/// Deterministic numbers in [-0.5, 0.5), scaled.
torch::Tensor numbers(std::vector<std::int64_t> shape, double scale)
{
    auto values = at::empty(shape, at::kFloat);
    for (std::int64_t i = 0; i < values.numel(); ++i)
        values.data_ptr<float>()[i] =
            static_cast<float>(scale * (std::fmod(0.6180339887 * static_cast<double>(i % 65'537 * 31 + i), 1.0) - 0.5));
    return values;
}

void add(fresco::SafeTensors& contents, const std::string& key, std::int64_t outputs, std::int64_t inputs)
{
    contents.tensors[key + ".weight"] = numbers({outputs, inputs, 3, 3}, 1 / std::sqrt(static_cast<double>(inputs)));
    contents.tensors[key + ".bias"] = numbers({outputs}, 0.1);
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

torch::Tensor picture(std::int64_t height, std::int64_t width)
{
    return numbers({3, height, width}, 1) + 0.5;
}

/// A 3x3 convolution with bias and rectifier, in double, one sum at a time.
torch::Tensor plain_convolution(const torch::Tensor& maps, const torch::Tensor& weights, const torch::Tensor& bias, bool reflect)
{
    const auto in = maps.to(at::kDouble).contiguous();
    const auto w = weights.to(at::kDouble).contiguous();
    const auto height = in.size(1);
    const auto width = in.size(2);
    auto out = at::zeros({w.size(0), height, width}, at::kDouble);
    const auto mirrored = [](std::int64_t i, std::int64_t n) { return i < 0 ? -i : i >= n ? 2 * n - 2 - i : i; };
    const double* value = in.data_ptr<double>();
    const double* factor = w.data_ptr<double>();
    for (std::int64_t k = 0; k < w.size(0); ++k)
        for (std::int64_t y = 0; y < height; ++y)
            for (std::int64_t x = 0; x < width; ++x)
            {
                double sum = bias[k].item<double>();
                for (std::int64_t c = 0; c < in.size(0); ++c)
                    for (std::int64_t j = 0; j < 3; ++j)
                        for (std::int64_t i = 0; i < 3; ++i)
                        {
                            const auto sy = reflect ? mirrored(y + j - 1, height) : y + j - 1;
                            const auto sx = reflect ? mirrored(x + i - 1, width) : x + i - 1;
                            if (sy >= 0 && sy < height && sx >= 0 && sx < width)
                                sum += value[(c * height + sy) * width + sx] * factor[((k * in.size(0) + c) * 3 + j) * 3 + i];
                        }
                out[k][y][x] = std::max(sum, 0.0);
            }
    return out;
}

}  // namespace

TEST_CASE("VGG-19 agrees with sums by hand, in both conventions")
{
    const auto contents = three_layers();
    const auto layers = vgg19::convolutions(contents, "w");
    const auto input = picture(6, 7);
    for (const bool caffe : {false, true})
    {
        const auto format = caffe ? vgg19::caffe_input() : vgg19::torchvision_input();
        auto expected = at::empty({3, 6, 7}, at::kDouble);
        const double means[2][3] = {{0.485, 0.456, 0.406}, {103.939, 116.779, 123.68}};
        const double deviations[3] = {0.229, 0.224, 0.225};
        for (std::int64_t c = 0; c < 3; ++c)
            expected[c] = caffe ? input[2 - c].to(at::kDouble) * 255 - means[1][c]
                                : (input[c].to(at::kDouble) - means[0][c]) / deviations[c];
        const vgg19::Vgg19 network(layers, format, vgg19::Pooling::max);
        const auto maps = network.encode(input, {"relu1_1", "relu1_2"});
        for (std::size_t i = 0; i < 2; ++i)
        {
            expected = plain_convolution(expected, layers[i].weights, layers[i].bias, caffe);
            CHECK(at::allclose(maps[i].to(at::kDouble), expected, 1e-4, 1e-3));
        }
    }
}

TEST_CASE("Pooling takes the largest or the mean of 2x2 cells")
{
    const auto layers = vgg19::convolutions(three_layers(), "w");
    const auto input = picture(8, 8);
    for (const auto pooling : {vgg19::Pooling::max, vgg19::Pooling::average})
    {
        const vgg19::Vgg19 network(layers, vgg19::torchvision_input(), pooling);
        const auto maps = network.encode(input, {"relu1_2", "relu2_1"});
        const auto cells = maps[0].reshape({64, 4, 2, 4, 2}).to(at::kDouble);
        const auto joined = pooling == vgg19::Pooling::max ? cells.amax(std::vector<std::int64_t>{2, 4})
                                                           : cells.mean(std::vector<std::int64_t>{2, 4});
        CHECK(at::allclose(maps[1].to(at::kDouble), plain_convolution(joined, layers[2].weights, layers[2].bias, false), 1e-4,
                           1e-3));
    }
}

TEST_CASE("Layers: stride, channels, reach, and the defaults for style and content")
{
    const vgg19::Vgg19 network(vgg19::convolutions(three_layers(), "w"), {}, vgg19::Pooling::max);
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
    CHECK(network.encode(picture(1, 1), {"relu2_1"}).at(0).sizes() == at::IntArrayRef({128, 0, 0}));
    CHECK(network.encode(picture(3, 5), {"relu2_1"}).at(0).sizes() == at::IntArrayRef({128, 1, 2}));
}

TEST_CASE("The input format: metadata decides over keys")
{
    auto contents = three_layers();
    CHECK(vgg19::input_format(contents, "w").bgr == false);
    CHECK(vgg19::input_format(contents, "w").padding == vgg19::Padding::zero);
    contents.metadata["input"] = "BGR in 0..255 minus (103.939, 116.779, 123.68)";
    CHECK(vgg19::input_format(contents, "w").bgr);
    CHECK(vgg19::input_format(contents, "w").padding == vgg19::Padding::zero);
    contents.metadata["padding"] = "reflect";
    CHECK(vgg19::input_format(contents, "w").padding == vgg19::Padding::reflect);
    contents.metadata["padding"] = "circular";
    CHECK_THROWS_WITH(vgg19::input_format(contents, "w.st"), Catch::Contains("w.st") && Catch::Contains("circular"));
    contents.metadata["input"] = "YUV";
    CHECK_THROWS_WITH(vgg19::input_format(contents, "w.st"), Catch::Contains("w.st") && Catch::Contains("YUV"));

    fresco::SafeTensors gatys;
    add(gatys, "conv1_1", 64, 3);
    CHECK(vgg19::input_format(gatys, "w").bgr);
    CHECK(vgg19::input_format(gatys, "w").padding == vgg19::Padding::reflect);
    CHECK(vgg19::convolutions(gatys, "w").at(0).layer == "relu1_1");
}

TEST_CASE("Weights that are not VGG-19's are refused with file and tensor")
{
    const auto refused = [](fresco::SafeTensors contents, const std::string& tensor)
    { CHECK_THROWS_WITH(vgg19::convolutions(contents, "w.st"), Catch::Contains("w.st") && Catch::Contains(tensor)); };
    auto contents = three_layers();
    contents.tensors["features.2.weight"] = numbers({64, 32, 3, 3}, 1);
    refused(contents, "features.2.weight");
    contents = three_layers();
    contents.tensors["features.5.bias"] = numbers({64}, 1);
    refused(contents, "features.5.bias");
    contents = three_layers();
    contents.tensors.erase("features.2.bias");
    refused(contents, "features.2.bias");
    contents = three_layers();
    contents.tensors.erase("features.2.weight");
    refused(contents, "features.2.weight");
    contents = three_layers();
    contents.tensors.erase("features.0.weight");
    refused(contents, "features.0.weight");
    contents = three_layers();
    contents.tensors["features.0.weight"] = at::zeros({64, 3, 3, 3}, at::kInt);
    refused(contents, "features.0.weight");
    contents = three_layers();
    contents.tensors["features.0.bias"][3] = std::nanf("");
    refused(contents, "features.0.bias");
}

TEST_CASE("features.vgg19 as a component")
{
    fresco::testing::TemporaryFolder folder;
    const auto file = folder.path() / "weights.safetensors";
    fresco::write_safetensors(file, three_layers());
    auto made = fresco::testing::make_from_plugin(FRESCO_PLUGIN_FILE, "features.vgg19");
    auto& network = dynamic_cast<fresco::FeatureNetwork&>(*made);
    fresco::testing::TestFactory factory;
    network.configure(fresco::Value::Map{{"weights", file.string()}}, factory);
    network.prepare({});
    CHECK(network.encode(picture(8, 8), {"relu2_1"}).at(0).sizes() == at::IntArrayRef({128, 4, 4}));
    CHECK_THROWS_WITH(network.encode(picture(8, 8), {"relu3_1"}), Catch::Contains("relu3_1") && Catch::Contains("relu2_1"));
    network.configure(fresco::Value::Map{{"weights", (folder.path() / "none").string()}}, factory);
    CHECK_THROWS_AS(network.prepare({}), fresco::MissingInput);
}

TEST_CASE("Gradients through VGG-19 agree with finite differences, and threads change no byte")
{
    const vgg19::Vgg19 network(vgg19::convolutions(three_layers(), "w"), vgg19::torchvision_input(), vgg19::Pooling::max);
    const auto input = picture(8, 8).to(at::kDouble);
    const auto value = [&](const torch::Tensor& p) { return network.encode(p, {"relu2_1"})[0].pow(2).sum(); };
    auto variable = input.clone().requires_grad_();
    value(variable).backward();
    for (std::int64_t i = 0; i < input.numel(); i += 17)
    {
        auto up = input.clone();
        auto down = input.clone();
        up.view({-1})[i] += 1e-6;
        down.view({-1})[i] -= 1e-6;
        const double slope = (value(up).item<double>() - value(down).item<double>()) / 2e-6;
        CHECK(variable.grad().flatten()[i].item<double>() == Approx(slope).epsilon(1e-3));
    }

    const int before = at::get_num_threads();
    const auto run = [&](int threads)
    {
        at::set_num_threads(threads);
        auto pixels = picture(64, 80).requires_grad_();
        const auto map = network.encode(pixels, {"relu2_1"})[0];
        map.pow(2).sum().backward();
        return std::pair{map.detach(), pixels.grad()};
    };
    const auto one = run(1);
    const auto two = run(2);
    at::set_num_threads(before);
    CHECK(at::equal(one.first, two.first));
    CHECK(at::equal(one.second, two.second));
}

TEST_CASE("Real weights give activations of unit mean")
{
    const auto file = shared_data("weights/vgg19_conv1_1-conv3_1.safetensors", "Real weights give activations of unit mean");
    if (file.empty())
        return;
    const auto contents = fresco::read_safetensors(file);
    const auto format = vgg19::input_format(contents, file);
    CHECK(format.bgr);
    CHECK(format.padding == vgg19::Padding::reflect);
    const vgg19::Vgg19 network(vgg19::convolutions(contents, file), format, vgg19::Pooling::max);
    REQUIRE(network.layers().size() == 5);
    CHECK(network.layers().back().content);
    // The scaling is to a mean of 1 over natural pictures; noise is none, but stays within a small factor.
    for (const auto& map : network.encode(picture(64, 64), {"relu1_1", "relu2_1", "relu3_1"}))
    {
        CHECK(map.mean().item<double>() > 0.1);
        CHECK(map.mean().item<double>() < 10);
    }
}
