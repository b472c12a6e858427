#include "low_pass.h"

#include <ATen/ATen.h>

#include <catch2/catch.hpp>

#include <functional>

namespace cg = content_gradients;

namespace
{

torch::Tensor ramp(std::int64_t height, std::int64_t width)
{
    return at::arange(width, at::kDouble).reshape({1, 1, width}).expand({1, height, width}).contiguous();
}

torch::Tensor everywhere(std::int64_t height, std::int64_t width)
{
    return at::ones({height, width}, at::kBool);
}

}  // namespace

TEST_CASE("A cell is the mean of its valid pixels, and valid when half of them are")
{
    auto mask = everywhere(2, 6);
    mask[0][2] = false;
    mask[0][4] = mask[1][4] = mask[0][5] = false;
    const auto cells = cg::low_pass(ramp(2, 6), mask, 2);
    CHECK(cells.values[0][0][0].item<double>() == Approx(0.5));
    CHECK(cells.values[0][0][1].item<double>() == Approx((2.0 + 3 + 3) / 3));
    CHECK(cells.values[0][0][2].item<double>() == 0);
    CHECK(cells.valid[0][1].item<double>() == 1);
    CHECK(cells.valid[0][2].item<double>() == 0);
}

TEST_CASE("Steps of a ramp against a flat picture")
{
    const auto flat = cg::low_pass(at::zeros({1, 4, 8}, at::kDouble), everywhere(4, 8), 2);
    const auto slope = cg::low_pass(ramp(4, 8), everywhere(4, 8), 2);
    // 2 rows of 3 horizontal steps of 2 each, 4 vertical steps of 0.
    CHECK(cg::step_difference(slope, flat).item<double>() == Approx(6 * 4.0 / 10));
    CHECK(cg::value_difference(slope, flat).item<double>() == Approx((0.25 + 6.25 + 20.25 + 42.25) / 4));
    CHECK(cg::step_difference(slope, slope).item<double>() == 0);
}

TEST_CASE("Nothing valid gives no value")
{
    const auto none = cg::low_pass(ramp(4, 8), at::zeros({4, 8}, at::kBool), 2);
    CHECK_FALSE(cg::step_difference(none, none).defined());
    CHECK_FALSE(cg::value_difference(none, none).defined());
    const auto tiny = cg::low_pass(ramp(4, 8), everywhere(4, 8), 8);
    CHECK(tiny.values.numel() == 0);
    CHECK_FALSE(cg::step_difference(tiny, tiny).defined());
}

TEST_CASE("Luminance weights add up to one")
{
    CHECK(cg::luminance(at::full({3, 1, 1}, 0.5, at::kDouble)).item<double>() == Approx(0.5));
}

TEST_CASE("Gradients of both differences agree with finite differences")
{
    auto mask = everywhere(4, 6);
    mask[1][1] = mask[2][4] = mask[3][4] = mask[3][5] = false;
    const auto picture = (ramp(4, 6) * ramp(6, 4).transpose(1, 2) * 0.37).frac();
    const auto target = cg::low_pass(at::full({1, 4, 6}, 0.4, at::kDouble), mask, 2);
    const std::function<torch::Tensor(const torch::Tensor&)> value = [&](const torch::Tensor& p)
    {
        const auto cells = cg::low_pass(p, mask, 2);
        return cg::step_difference(cells, target) + cg::value_difference(cells, target);
    };
    auto variable = picture.clone().requires_grad_();
    value(variable).backward();
    for (std::int64_t i = 0; i < picture.numel(); ++i)
    {
        auto up = picture.clone();
        auto down = picture.clone();
        up.view({-1})[i] += 1e-6;
        down.view({-1})[i] -= 1e-6;
        const double slope = (value(up).item<double>() - value(down).item<double>()) / 2e-6;
        CHECK(variable.grad().flatten()[i].item<double>() == Approx(slope).epsilon(1e-5).margin(1e-8));
    }
}
