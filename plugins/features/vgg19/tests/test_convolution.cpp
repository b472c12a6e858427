#include "convolution.h"
#include "kernels_here.h"
#include "random_numbers.h"

#include <fresco/parallel.h>

#include "catch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

using namespace vgg19;
using fresco::testing::random_numbers;

namespace
{

Parallel on_threads(int threads)
{
    return [threads](std::size_t count, const auto& work) { fresco::parallel_for(count, 1, threads, work); };
}

std::vector<const winograd::Kernel*> kernels_here()
{
    return fresco::testing::kernels_here(winograd::base_kernel(), winograd::avx2_kernel(), winograd::avx512_kernel());
}

/// Sums one by one, in double: H x W x C -> (H + 2 beyond) x (W + 2 beyond) x K.
std::vector<double> summed(const std::vector<float>& in, MapsShape shape, const std::vector<float>& weights, int outputs,
                           int inputs, Border border, int beyond)
{
    const auto place = [&](int i, int count)
    {
        if (i >= 0 && i < count)
            return i;
        if (border == Border::zero)
            return -1;
        return count == 1 ? 0 : i < 0 ? -i : 2 * count - 2 - i;
    };
    std::vector<double> out;
    for (int y = -beyond; y < shape.height + beyond; ++y)
        for (int x = -beyond; x < shape.width + beyond; ++x)
            for (int k = 0; k < outputs; ++k)
            {
                double sum = 0;
                for (int j = 0; j < 3; ++j)
                    for (int i = 0; i < 3; ++i)
                    {
                        const int sy = place(y + j - 1, shape.height);
                        const int sx = place(x + i - 1, shape.width);
                        for (int c = 0; c < inputs && sy >= 0 && sx >= 0; ++c)
                            sum +=
                                static_cast<double>(in[static_cast<std::size_t>((sy * shape.width + sx) * shape.channels + c)]) *
                                static_cast<double>(weights[static_cast<std::size_t>(((k * inputs + c) * 3 + j) * 3 + i)]);
                    }
                out.push_back(sum);
            }
    return out;
}

double largest_difference(const std::vector<float>& a, const std::vector<double>& b)
{
    REQUIRE(a.size() == b.size());
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = std::max(worst, std::abs(static_cast<double>(a[i]) - b[i]));
    return worst;
}

/// Gradients that no rectifier holds back.
ResponseGradient everywhere(const std::vector<float>& gradient, MapsShape shape)
{
    static const std::vector<std::uint8_t> ones(1 << 23, 1);
    REQUIRE(gradient.size() <= ones.size());
    return {.of_next = {gradient.data(), static_cast<std::size_t>(shape.width * shape.channels)}, .masks = ones.data()};
}

/// Expected accuracy of sums of `count` products of numbers in [-0.5, 0.5].
double accuracy(int count)
{
    return 6e-6 * std::sqrt(static_cast<double>(count)) + 3e-6;
}

}  // namespace

TEST_CASE("Every kernel's convolution is the sum over the window, rectified, for every size and border")
{
    for (const auto* kernel : kernels_here())
        for (const auto [height, width, inputs, outputs] : {std::array{1, 1, 16, 16},
                                                            {1, 7, 16, 32},
                                                            {2, 2, 3, 48},
                                                            {5, 4, 32, 80},
                                                            {9, 13, 16, 64},
                                                            {27, 30, 48, 64},
                                                            {9, 13, 256, 256}})
            for (const auto border : {Border::zero, Border::reflect})
            {
                INFO(kernel->name << ", " << height << " x " << width << ", " << inputs << " -> " << outputs);
                const MapsShape shape{height, width, (inputs + 15) / 16 * 16};
                const auto in = random_numbers(shape.size(), 1);
                const auto weights = random_numbers(static_cast<std::size_t>(9 * inputs * outputs), 2);
                const auto bias = random_numbers(static_cast<std::size_t>(outputs), 3);
                auto expected = summed(in, shape, weights, outputs, inputs, border, 0);
                for (std::size_t i = 0; i < expected.size(); ++i)
                    expected[i] = std::max(0.0, expected[i] + static_cast<double>(bias[i % bias.size()]));
                const Convolution3x3 convolution(weights, outputs, inputs, Convolution3x3::Way::there, *kernel);
                REQUIRE(convolution.outputs() == outputs);
                std::vector<float> out(expected.size(), -1.0F);
                std::vector<std::uint8_t> mask(expected.size(), 7);
                convolution.rectified(in.data(), shape, border, bias.data(), {.maps = out.data(), .masks = mask.data()},
                                      on_threads(1));
                CHECK(largest_difference(out, expected) < accuracy(9 * inputs));
                CHECK(std::ranges::equal(mask, out, [](int positive, float value) { return positive == (value > 0 ? 1 : 0); }));
            }
}

TEST_CASE("Every kernel's way back is the sum over the filters turned round")
{
    for (const auto* kernel : kernels_here())
        // Few tiles, and as many as fill blocks and leave one, two or three groups over.
        for (const auto [height, width, inputs, outputs] :
             {std::array{1, 2, 16, 16}, {7, 18, 80, 48}, {9, 30, 48, 144}, {67, 65, 16, 16}, {65, 77, 3, 16}, {9, 13, 256, 256}})
            for (const int beyond : {0, 1})
            {
                INFO(kernel->name << ", " << height << " x " << width << ", " << inputs << " -> " << outputs);
                const MapsShape shape{height, width, outputs};
                const auto gradient = random_numbers(shape.size(), 11);
                const auto weights = random_numbers(static_cast<std::size_t>(9 * inputs * outputs), 12);
                const int filled_up = (inputs + 15) / 16 * 16;
                std::vector<float> swapped(static_cast<std::size_t>(9 * filled_up * outputs));
                for (int k = 0; k < outputs; ++k)
                    for (int c = 0; c < inputs; ++c)
                        for (int i = 0; i < 9; ++i)
                            swapped[static_cast<std::size_t>((c * outputs + k) * 9 + 8 - i)] =
                                weights[static_cast<std::size_t>((k * inputs + c) * 9 + i)];
                const auto expected = summed(gradient, shape, swapped, filled_up, outputs, Border::zero, beyond);
                const Convolution3x3 back(weights, outputs, inputs, Convolution3x3::Way::back, *kernel);
                REQUIRE((back.inputs() == outputs && back.outputs() == filled_up));
                std::vector<float> out(expected.size(), -1.0F);
                back.back(everywhere(gradient, shape), shape, beyond, out.data(), on_threads(2));
                CHECK(largest_difference(out, expected) < accuracy(9 * outputs));
            }
}

TEST_CASE("Every kernel pools the larger of two by two, and gives its gradient back to one of the largest")
{
    const auto* kernel = GENERATE(from_range(kernels_here()));
    INFO(kernel->name);
    // Channel 0 of 3 x 5 pixels; the other channels are 0. The filters leave everything as it is.
    const std::vector<float> values{1, 5, 2, 2, 9, 4, 3, 2, 2, 9, 9, 9, 9, 9, 9};
    const MapsShape shape{3, 5, 16};
    std::vector<float> weights(16 * 16 * 9);
    for (std::size_t i = 0; i < 16; ++i)
        weights[(i * 16 + i) * 9 + 4] = 1;
    std::vector<float> maps(shape.size()), out(shape.size()), pooled(2 * 16), of_next(2 * 16), gradient(shape.size());
    for (std::size_t i = 0; i < values.size(); ++i)
        maps[i * 16] = values[i];
    const std::vector<float> bias(16), own(shape.size(), 1.0F);
    std::vector<std::uint8_t> mask(shape.size(), 7), chosen(2 * 16, 7);
    Convolution3x3(weights, 16, 16, Convolution3x3::Way::there, *kernel)
        .rectified(maps.data(), shape, Border::zero, bias.data(),
                   {.maps = out.data(), .masks = mask.data(), .pooled = pooled.data(), .chosen = chosen.data()}, on_threads(1));
    CHECK(out[16] == Approx(5));
    CHECK(pooled[0] == Approx(5));
    CHECK(pooled[16] == Approx(2));
    CHECK((chosen[0] == 1 && chosen[16] < 4 && chosen[1] == 4));

    of_next[0] = 8;
    of_next[16] = 4;
    Convolution3x3(weights, 16, 16, Convolution3x3::Way::back, *kernel)
        .back({.own = own.data(), .of_next = {of_next.data(), 32}, .masks = mask.data(), .chosen = chosen.data()}, shape, 0,
              gradient.data(), on_threads(1));
    std::vector<float> expected(15, 1.0F);
    expected[1] = 9;
    expected[std::array{2U, 3U, 7U, 8U}.at(chosen[16])] = 5;
    for (std::size_t i = 0; i < expected.size(); ++i)
        CHECK(gradient[i * 16] == Approx(expected[i]));
}
