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
#include <ATen/ops/mm.h>
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

double largest_difference(const at::Tensor& a, const at::Tensor& b)
{
    return (a.to(at::kDouble) - b.to(at::kDouble)).abs().max().item<double>();
}

struct Threads
{
    int before = at::get_num_threads();
    ~Threads() { at::set_num_threads(before); }
};

/// CHECKs that `make` gives the same bytes for any number of threads, and returns them.
template <class Make>
at::Tensor same_for_any_threads(const Make& make)
{
    const Threads restore;
    at::set_num_threads(1);
    const at::Tensor one = make();
    for (const int threads : {2, 3})
    {
        at::set_num_threads(threads);
        CHECK(same_bytes(one, make()));
    }
    return one;
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

TEST_CASE("matrix_product and its gradients are those of libtorch, of any strides and for any number of threads")
{
    // The product itself is tested where it is made: multiply_matrices.
    const auto a = random_tensor({33, 300}, 1);
    const auto b = random_tensor({17, 300}, 2).t();
    const auto direction = random_tensor({33, 17}, 3);
    const auto wide = [](const at::Tensor& tensor) { return tensor.to(at::kDouble); };
    for (const int gradient : {-1, 0, 1})
    {
        const auto made = [&](const at::Tensor& left, const at::Tensor& right, const at::Tensor& along)
        {
            const std::vector<at::Tensor> factors{left.detach().set_requires_grad(true), right.detach().set_requires_grad(true)};
            const auto value = matrix_product(factors[0], factors[1]);
            return gradient < 0 ? value.detach()
                                : torch::autograd::grad({value}, {factors[static_cast<std::size_t>(gradient)]}, {along})[0];
        };
        const auto expected = gradient < 0    ? at::mm(wide(a), wide(b))
                              : gradient == 0 ? at::mm(wide(direction), wide(b).t())
                                              : at::mm(wide(a).t(), wide(direction));
        CHECK(largest_difference(same_for_any_threads([&] { return made(a, b, direction); }), expected) < 1e-4);
        CHECK(largest_difference(made(wide(a), wide(b), wide(direction)), expected) < 1e-12);
    }
    CHECK(matrix_product(a, at::zeros({300, 0}, at::kFloat)).sizes() == at::IntArrayRef({33, 0}));
    CHECK_THROWS_AS(matrix_product(a, a), std::invalid_argument);
    CHECK_THROWS_AS(matrix_product(a, wide(b)), std::invalid_argument);
}

TEST_CASE("ordered sums are right, differentiable, and the same for any number of threads")
{
    for (const std::int64_t count : {0, 1, 7, 9, 16385, 1000003})
    {
        CAPTURE(count);
        const auto values = random_tensor({count}, 5);
        const auto expected = values.to(at::kDouble).sum().item<double>();
        const auto sum = same_for_any_threads([&] { return ordered_sum(values); });
        REQUIRE(sum.dim() == 0);
        CHECK(sum.item<float>() == Approx(expected).margin(1e-6));
        const auto mean = expected / static_cast<double>(std::max<std::int64_t>(1, count));
        CHECK(ordered_mean(values).item<float>() == Approx(mean).margin(1e-9));
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
    const auto x = random_tensor({4, 3, 50000}, 8);
    const auto parts = ordered_sum(x, 2);
    REQUIRE(parts.sizes() == at::IntArrayRef({4, 3}));
    CHECK(same_bytes(parts[2][1], ordered_sum(x[2][1])));
    CHECK(largest_difference(ordered_mean(x, -1), parts / 50000.0) < 1e-9);
    const auto across = same_for_any_threads([&] { return ordered_sum(x, 0); });
    CHECK(largest_difference(across, (x[0] + x[1]) + (x[2] + x[3])) < 1e-6);
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

TEST_CASE("a loss that remembers nothing refuses a state")
{
    Forgetful loss;
    CHECK(loss.state().empty());
    loss.restore({});
    CHECK_THROWS_AS(loss.restore({{"mean", at::zeros({1})}}), Error);
}
