#include "random_tensor.h"

#include "catch.h"

#include <fresco/torch/features.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/tensor.h>
#include <fresco/torch/testing.h>

#include <fresco/error.h>

#include <torch/csrc/autograd/autograd.h>
#include <torch/types.h>

#include <ATen/Parallel.h>
#include <ATen/ops/tensor.h>
#include <ATen/ops/zeros.h>

#include <cmath>
#include <cstring>
#include <limits>

using namespace fresco;
using fresco::testing::random_tensor;

namespace
{

bool same_bytes(const at::Tensor& a, const at::Tensor& b)
{
    const auto x = a.contiguous();
    const auto y = b.contiguous();
    return x.sizes() == y.sizes() && x.nbytes() == y.nbytes() && std::memcmp(x.data_ptr(), y.data_ptr(), x.nbytes()) == 0;
}

/// The obvious product, in double precision.
at::Tensor slow_product(const at::Tensor& a, const at::Tensor& b)
{
    const auto x = a.detach().to(at::kDouble).contiguous();
    const auto y = b.detach().to(at::kDouble).contiguous();
    auto result = at::zeros({x.size(0), y.size(1)}, at::kDouble);
    auto out = result.accessor<double, 2>();
    const auto xa = x.accessor<double, 2>();
    const auto ya = y.accessor<double, 2>();
    for (std::int64_t i = 0; i < x.size(0); ++i)
        for (std::int64_t k = 0; k < x.size(1); ++k)
            for (std::int64_t j = 0; j < y.size(1); ++j)
                out[i][j] += xa[i][k] * ya[k][j];
    return result;
}

double largest_difference(const at::Tensor& a, const at::Tensor& b)
{
    if (a.numel() == 0)
        return 0;
    return (a.to(at::kDouble) - b.to(at::kDouble)).abs().max().item<double>();
}

struct Threads
{
    int before = at::get_num_threads();
    ~Threads() { at::set_num_threads(before); }
};

struct Product
{
    at::Tensor value;
    at::Tensor for_a;
    at::Tensor for_b;
};

Product product_and_gradients(const at::Tensor& a0, const at::Tensor& b0, const at::Tensor& direction)
{
    const auto a = a0.detach().clone().set_requires_grad(true);
    const auto b = b0.detach().clone().set_requires_grad(true);
    const auto value = matrix_product(a, b);
    const auto gradients = torch::autograd::grad({value}, {a, b}, {direction});
    return {value.detach(), gradients[0], gradients[1]};
}

}  // namespace

TEST_CASE("pictures become planes and come back")
{
    Raster8 picture(3, 2, 3);
    for (std::size_t i = 0; i < picture.values.size(); ++i)
        picture.values[i] = static_cast<std::uint8_t>(i * 15);
    const auto tensor = to_tensor(picture);
    REQUIRE(tensor.sizes() == at::IntArrayRef({3, 2, 3}));
    const auto at = tensor.accessor<float, 3>();
    CHECK(at[0][0][0] == 0.0F);
    CHECK(at[2][0][1] == Approx(picture.at(1, 0, 2) / 255.0));
    CHECK(at[1][1][2] == Approx(picture.at(2, 1, 1) / 255.0));
    CHECK(to_raster8(tensor) == picture);

    RasterF floats(2, 3, 1);
    floats.at(1, 2) = 7.5F;
    CHECK(to_tensor(floats)[0][2][1].item<float>() == 7.5F);
}

TEST_CASE("eight-bit conversion rounds and clamps")
{
    const auto tensor = at::tensor({-0.5F, 1.5F, 0.5F, std::numeric_limits<float>::quiet_NaN(), 0.001F}).view({1, 1, 5});
    CHECK(to_raster8(tensor).values == (std::vector<std::uint8_t>{0, 255, 128, 0, 0}));
}

TEST_CASE("matrix_product equals the triple loop for every kind of shape")
{
    const Threads restore;
    const std::vector<std::array<std::int64_t, 3>> shapes{{1, 1, 1},     {1, 5, 1},      {7, 1, 3},    {1, 64, 9},
                                                          {64, 3, 1},    {3, 9, 4000},   {33, 65, 17}, {64, 1000, 64},
                                                          {5, 40000, 2}, {128, 27, 513}, {16, 16, 16}};
    for (const auto& [m, k, n] : shapes)
    {
        CAPTURE(m, k, n);
        for (const auto type : {at::kFloat, at::kDouble})
        {
            const auto a = random_tensor({m, k}, 1, type);
            const auto b = random_tensor({k, n}, 2, type);
            const auto direction = random_tensor({m, n}, 3, type);
            at::set_num_threads(1);
            const auto one = product_and_gradients(a, b, direction);
            const double tolerance =
                (type == at::kFloat ? 2e-6 : 1e-13) * std::sqrt(static_cast<double>(std::max({m, k, n}))) * 4;
            CHECK(largest_difference(one.value, slow_product(a, b)) <= tolerance);
            CHECK(largest_difference(one.for_a, slow_product(direction, b.t())) <= tolerance);
            CHECK(largest_difference(one.for_b, slow_product(a.t(), direction)) <= tolerance);
            if (type == at::kDouble)
                continue;
            for (const int threads : {2, 3})
            {
                at::set_num_threads(threads);
                const auto more = product_and_gradients(a, b, direction);
                CHECK(same_bytes(one.value, more.value));
                CHECK(same_bytes(one.for_a, more.for_a));
                CHECK(same_bytes(one.for_b, more.for_b));
            }
        }
    }
}

TEST_CASE("matrix_product takes strided operands and empty ones and refuses the rest")
{
    const auto a = random_tensor({6, 4}, 4);
    CHECK(largest_difference(matrix_product(a.t(), a), slow_product(a.t(), a)) < 1e-5);
    CHECK(matrix_product(a, at::zeros({4, 0}, at::kFloat)).sizes() == at::IntArrayRef({6, 0}));
    CHECK(matrix_product(at::zeros({2, 0}, at::kFloat), at::zeros({0, 3}, at::kFloat)).abs().max().item<float>() == 0);
    CHECK_THROWS_AS(matrix_product(a, a), std::invalid_argument);
    CHECK_THROWS_AS(matrix_product(a.t(), a.to(at::kDouble)), std::invalid_argument);
}

TEST_CASE("ordered sums are right, differentiable, and the same for any number of threads")
{
    const Threads restore;
    for (const std::int64_t count : {0, 1, 7, 8, 9, 16384, 16385, 1000003, 3000001})
    {
        CAPTURE(count);
        const auto values = random_tensor({count}, 5);
        long double expected = 0;
        for (std::int64_t i = 0; i < count; ++i)
            expected += values.data_ptr<float>()[i];
        at::set_num_threads(1);
        const auto one = ordered_sum(values);
        REQUIRE(one.dim() == 0);
        CHECK(one.item<float>() == Approx(static_cast<double>(expected)).margin(1e-6));
        CHECK(ordered_mean(values).item<float>() ==
              Approx(static_cast<double>(expected) / static_cast<double>(std::max<std::int64_t>(1, count))).margin(1e-9));
        for (const int threads : {2, 3})
        {
            at::set_num_threads(threads);
            CHECK(same_bytes(one, ordered_sum(values)));
        }
    }
    const auto x = random_tensor({3, 4, 5}, 6, at::kDouble).set_requires_grad(true);
    const auto square = torch::autograd::grad({ordered_mean(x * x)}, {x})[0];
    CHECK(largest_difference(square, x.detach() * (2.0 / 60.0)) < 1e-15);
    const auto weights = random_tensor({3, 5}, 7, at::kDouble);
    const auto along = torch::autograd::grad({ordered_sum(ordered_sum(x, 1) * weights)}, {x})[0];
    CHECK(largest_difference(along, weights.unsqueeze(1).expand({3, 4, 5})) == 0);
}

TEST_CASE("ordered sums over a dimension equal sums of slices")
{
    const Threads restore;
    const auto x = random_tensor({4, 3, 50000}, 8);
    const auto parts = ordered_sum(x, 2);
    REQUIRE(parts.sizes() == at::IntArrayRef({4, 3}));
    CHECK(same_bytes(parts[2][1], ordered_sum(x[2][1])));
    CHECK(largest_difference(ordered_mean(x, -1), parts / 50000.0) < 1e-9);
    at::set_num_threads(1);
    const auto one = ordered_sum(x, 0);
    at::set_num_threads(2);
    CHECK(same_bytes(one, ordered_sum(x, 0)));
    CHECK(largest_difference(one, (x[0] + x[1]) + (x[2] + x[3])) < 1e-6);
    CHECK_THROWS_AS(ordered_sum(x.to(at::kLong)), std::invalid_argument);
}

namespace
{
class Forgetful final : public Loss
{
    LossNeeds needs() const override { return {}; }
    void prepare(const PrepareContext&) override {}
    std::vector<LossTerm> evaluate(Part&) override { return {}; }
};
}  // namespace

TEST_CASE("an unknown feature layer is refused with the layers there are")
{
    const testing::ColorNetwork network;
    CHECK(network.layer("b").stride == 2);
    CHECK_THROWS_WITH(network.layer("third"), Catch::Contains("third") && Catch::Contains("a, b"));
}

TEST_CASE("a loss that remembers nothing refuses a state")
{
    Forgetful loss;
    CHECK(loss.state().empty());
    loss.restore({});
    CHECK_THROWS_AS(loss.restore({{"mean", at::zeros({1})}}), Error);
}
