#include "random_layers.h"
#include "vgg19.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <torch/csrc/autograd/autograd.h>

#include "catch.h"

#include <algorithm>
#include <cmath>
#include <far_device.h>
#include <utility>

using fresco::testing::random_tensor;

namespace
{

const std::vector<std::string> names{"relu1_1", "relu2_2", "relu3_1"};

torch::Tensor picture(std::int64_t height, std::int64_t width)
{
    return random_tensor({3, height, width}, 77) + 0.5;
}

/// A sum that weighs every response otherwise, and its gradient.
torch::Tensor gradient_of(const std::vector<torch::Tensor>& maps, const torch::Tensor& picture)
{
    auto sum = at::zeros({}, maps[0].options());
    for (std::size_t i = 0; i < maps.size(); ++i)
        sum = sum + (maps[i] * random_tensor(maps[i].sizes(), 100 + i).to(maps[i].options())).sum();
    return torch::autograd::grad({sum}, {picture})[0];
}

/// The maps of `names` by PyTorch's own functions, and by the published means and deviations.
std::vector<torch::Tensor> plainly_encoded(const fresco::weights::Vgg19Input& input, const torch::Tensor& picture,
                                           const std::vector<std::string>& names)
{
    const auto of_channels = [](std::vector<double> values) { return at::tensor(values, at::kDouble).view({3, 1, 1}); };
    auto maps = input.bgr ? picture.flip(0) * 255 - of_channels({103.939, 116.779, 123.68})
                          : (picture - of_channels({0.485, 0.456, 0.406})) / of_channels({0.229, 0.224, 0.225});
    maps = maps.unsqueeze(0);
    const bool reflect = input.padding == fresco::weights::Vgg19Padding::reflect;
    std::vector<torch::Tensor> result;
    for (const auto& layer : random_layers())
    {
        maps = layer.pooled ? at::max_pool2d(maps, {2, 2}) : maps;
        // A side of one pixel has nothing to reflect: the pixel is repeated.
        const auto padded = [&](bool is_one, at::IntArrayRef sides)
        { return is_one ? at::replication_pad2d(maps, sides) : at::reflection_pad2d(maps, sides); };
        maps = reflect ? padded(maps.size(2) == 1, {0, 0, 1, 1}) : maps;
        maps = reflect ? padded(maps.size(3) == 1, {1, 1, 0, 0}) : maps;
        maps = at::relu(at::conv2d(maps, layer.weights.to(at::kDouble), layer.bias.to(at::kDouble), 1, reflect ? 0 : 1));
        if (std::ranges::find(names, layer.layer) != names.end())
            result.push_back(maps.squeeze(0));
    }
    return result;
}

double relative_difference(const torch::Tensor& a, const torch::Tensor& b)
{
    const auto wide = b.to(at::kDouble);
    return (a.to(at::kDouble) - wide).norm().item<double>() / wide.norm().item<double>();
}

}  // namespace

TEST_CASE("The fast way and its gradient agree with libtorch's convolutions in double")
{
    // Odd sizes: the last row and column are not pooled. Small ones: maps become a pixel wide.
    const auto padding = GENERATE(fresco::weights::Vgg19Padding::zero, fresco::weights::Vgg19Padding::reflect);
    for (const auto& [height, width] : {std::pair{37, 51}, {5, 40}, {40, 5}, {8, 40}, {4, 4}})
        for (auto format : {fresco::weights::caffe_input(), fresco::weights::torchvision_input()})
        {
            CHECK(format.padding == fresco::weights::Vgg19Padding::zero);
            format.padding = padding;
            CAPTURE(height, width, format.bgr, padding);
            const vgg19::Vgg19 network(random_layers(), format);
            const auto fast_picture = picture(height, width).set_requires_grad(true);
            const auto slow_picture = fast_picture.detach().to(at::kDouble).set_requires_grad(true);
            auto fast = network.encode(fast_picture, names);
            auto slow = network.encode_generally(slow_picture, names);
            auto plain = plainly_encoded(format, slow_picture, names);
            for (std::size_t i = 0; i < names.size(); ++i)
            {
                REQUIRE(fast[i].sizes() == slow[i].sizes());
                CHECK(relative_difference(fast[i], slow[i]) < 1e-5);
                CHECK(relative_difference(slow[i], plain[i]) < 1e-12);
                CHECK(slow[i].flatten(1).t().is_contiguous());
            }
            // Layers that nobody asks a gradient of give none.
            for (auto* maps : {&fast, &slow, &plain})
                maps->erase(maps->begin() + (format.bgr ? 0 : 1));
            const auto slow_gradient = gradient_of(slow, slow_picture);
            CHECK(relative_difference(slow_gradient, gradient_of(plain, slow_picture)) < 1e-9);
            // A few of half a million responses are so close to 0, or to their neighbors', that rounding changes their order.
            CHECK(relative_difference(gradient_of(fast, fast_picture), slow_gradient) < 1e-2);
        }
}

TEST_CASE("Maps and gradients on another device are those here, and are not waited for")
{
    for (const auto& format : {fresco::weights::caffe_input(), fresco::weights::torchvision_input()})
    {
        vgg19::Vgg19 network(random_layers(), format);
        const auto near_picture = picture(22, 31).set_requires_grad(true);
        const auto near = network.encode_generally(near_picture, names);
        network.move_to(fresco::testing::far_device());
        const auto far_picture = near_picture.detach().to(fresco::testing::far_device()).set_requires_grad(true);
        fresco::testing::forget_far_traffic();
        const auto far = network.encode(far_picture, names);
        CHECK(fresco::testing::far_traffic().wait_count() == 0);
        for (std::size_t i = 0; i < names.size(); ++i)
            CHECK(relative_difference(far[i].cpu(), near[i]) < 1e-5);
        CHECK(relative_difference(gradient_of(far, far_picture).cpu(), gradient_of(near, near_picture)) < 1e-2);
    }
}

TEST_CASE("Features of a crop are the whole picture's up to margin_px from its border, and not closer")
{
    const vgg19::Vgg19 network(random_layers(), fresco::weights::caffe_input());
    const auto whole_picture = picture(120, 136);
    const std::int64_t top = 24, bottom = 96, left = 16, right = 116;
    for (const auto& layer : network.layers())
    {
        CAPTURE(layer.name);
        const auto whole = network.encode(whole_picture, {layer.name})[0];
        const auto crop = network.encode(whole_picture.slice(1, top, bottom).slice(2, left, right), {layer.name})[0];
        const auto s = layer.stride;
        const auto apart = [&](std::int64_t margin)
        {
            const auto inner = [&](const torch::Tensor& maps, std::int64_t y, std::int64_t x)
            {
                const auto first = [&](std::int64_t at) { return (at + margin + s - 1) / s; };
                const auto end = [&](std::int64_t at) { return (at - margin) / s; };
                return maps.slice(1, first(top) - y, end(bottom) - y).slice(2, first(left) - x, end(right) - x);
            };
            return relative_difference(inner(crop, top / s, left / s), inner(whole, 0, 0));
        };
        CHECK(apart(layer.margin_px) < 1e-5);
        CHECK(apart(layer.margin_px - s) > 1e-4);
    }
}

TEST_CASE("Around some pixels the features of their cells and the gradient there are the whole picture's")
{
    for (const auto& format : {fresco::weights::caffe_input(), fresco::weights::torchvision_input()})
    {
        const vgg19::Vgg19 network(random_layers(), format);
        const auto shown = picture(101, 123).set_requires_grad(true);
        fresco::Raster8 pixels(123, 101);
        for (int y = 0; y < pixels.height; ++y)
            for (int x = 0; x < pixels.width; ++x)
                pixels.at(x, y) = (x - 20) * (x - 20) + (y - 30) * (y - 30) < 200 || (x > 90 && y < 3) ? 1 : 0;
        const auto mask = at::from_blob(pixels.values.data(), {101, 123}, at::kByte).to(at::kFloat);
        // The gradient is read where features are, and at a place that only they see.
        auto gradient = pixels;
        for (int y = 28; y < 34; ++y)
            for (int x = 34; x < 40; ++x)
                gradient.at(x, y) = 1;
        const fresco::ReadPixels pixels_read{pixels, gradient};
        const auto where = at::from_blob(gradient.values.data(), {101, 123}, at::kByte).to(at::kFloat);
        /// Sum of the features that are read, and its gradient.
        const auto read = [&](const std::vector<torch::Tensor>& maps)
        {
            std::vector<torch::Tensor> result;
            for (const auto& map : maps)
            {
                const auto cells = at::max_pool2d(mask.unsqueeze(0), {101 / map.size(1), 123 / map.size(2)}).squeeze(0);
                result.push_back(map * cells.slice(0, 0, map.size(1)).slice(1, 0, map.size(2)));
            }
            const auto gradient = gradient_of(result, shown);
            result.push_back(gradient);
            return result;
        };
        const auto whole = read(network.encode(shown, names));
        const auto some = read(network.encode(shown, names, &pixels_read));
        for (std::size_t i = 0; i < names.size(); ++i)
            CHECK(relative_difference(some[i], whole[i]) < 1e-5);
        CHECK(relative_difference(some.back() * where, whole.back() * where) < 1e-5);
        CHECK((some.back().slice(2, 50, 80) == 0).all().item<bool>());
    }
}

TEST_CASE("What is not a number, and what grows beyond all numbers, comes through")
{
    auto broken = picture(40, 30);
    broken[0][20][15] = std::nanf("");
    const vgg19::Vgg19 network(random_layers(), fresco::weights::caffe_input());
    const auto maps = network.encode(broken, {"relu1_1", "relu2_1", "relu3_1"});
    for (const auto& of_layer : maps)
        CHECK(of_layer.isnan().any().item<bool>());
    auto big = random_layers();
    for (auto& layer : big)
        layer.weights = layer.weights * 1e10;
    const vgg19::Vgg19 large(big, fresco::weights::caffe_input());
    CHECK_FALSE(large.encode(picture(40, 30), {"relu3_1"})[0].isfinite().all().item<bool>());
}

TEST_CASE("Boxes of a sheet are encoded as pictures of their own, and so are their gradients")
{
    // Odd sides: pooling leaves the last row and column out. They touch the sheet's border and have one cell between them.
    struct Box
    {
        std::int64_t y, x, height, width;
        std::int64_t row, column;  // On the sheet.
    };
    const std::vector<Box> boxes{{0, 3, 21, 18, 0, 0}, {9, 0, 13, 31, 0, 20}, {5, 5, 12, 12, 24, 0}};
    fresco::Sheet sheet{36, 56, {}, {}, {}, {}};
    const auto numbers = [](const std::vector<std::int64_t>& list) { return at::tensor(list, at::kLong); };
    const auto whole = picture(25, 33).to(at::kDouble);
    std::vector<std::int64_t> pixels, places;
    for (const auto& box : boxes)
        for (std::int64_t i = 0; i < box.height * box.width; ++i)
        {
            pixels.push_back((box.y + i / box.width) * 33 + box.x + i % box.width);
            places.push_back((box.row + i / box.width) * sheet.width + box.column + i % box.width);
        }
    sheet.pixels = numbers(pixels);
    sheet.places = numbers(places);
    for (const int stride : {1, 2, 4})
    {
        std::vector<std::int64_t> borders, cells;
        for (const auto& box : boxes)
            for (std::int64_t y = -1; y <= box.height / stride; ++y)
                for (std::int64_t x = -1; x <= box.width / stride; ++x)
                {
                    const auto row = box.row / stride + y, column = box.column / stride + x;
                    const bool is_border = y < 0 || x < 0 || y == box.height / stride || x == box.width / stride;
                    if (row >= 0 && column >= 0 && row < sheet.height / stride && column < sheet.width / stride)
                        (is_border ? borders : cells).push_back(row * (sheet.width / stride) + column);
                }
        sheet.borders.emplace(stride, numbers(borders));
        sheet.cells.emplace(stride, numbers(cells));
    }
    // Channels in another order, each with a factor of its own.
    const fresco::weights::Vgg19Input mixed{.bgr = true, .scale = 2, .mean = {0.1, 0.2, 0.3}, .deviation = {1, 2, 3}};
    for (const auto& format : {fresco::weights::caffe_input(), fresco::weights::torchvision_input(), mixed})
    {
        const vgg19::Vgg19 network(random_layers(), format);
        auto together = whole.clone().set_requires_grad(true), apart = whole.clone().set_requires_grad(true);
        const auto fast = network.encode_sheet(together, names, sheet);
        std::vector<std::vector<torch::Tensor>> parts(names.size());
        for (const auto& box : boxes)
        {
            const auto own = apart.narrow(1, box.y, box.height).narrow(2, box.x, box.width);
            const auto maps = format.scale == 2 ? network.encode_generally(own, names) : plainly_encoded(format, own, names);
            for (std::size_t i = 0; i < names.size(); ++i)
                parts[i].push_back(maps[i].flatten(1));
        }
        std::vector<torch::Tensor> slow;
        for (const auto& of_layer : parts)
            slow.push_back(at::cat(of_layer, 1));
        for (std::size_t i = 0; i < names.size(); ++i)
            CHECK(relative_difference(fast[i], slow[i]) < 1e-12);
        CHECK(relative_difference(gradient_of(fast, together), gradient_of(slow, apart)) < 1e-12);
    }
    CHECK_FALSE(vgg19::Vgg19(random_layers(), {.padding = fresco::weights::Vgg19Padding::reflect}).takes_sheets());
}
