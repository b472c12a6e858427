#include "far_device.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <torch/csrc/autograd/autograd.h>

#include "catch.h"

using fresco::testing::far_device;
using fresco::testing::far_traffic;
using fresco::testing::forget_far_traffic;

TEST_CASE("on the far device operators, views, changes in place and gradients give what they give on the processor")
{
    const auto x = at::arange(24, at::kFloat).view({2, 3, 4}) / 7;
    const auto work = [](const at::Tensor& on)
    {
        auto a = on.detach().clone().set_requires_grad(true);
        auto b = a * 2 + 1;
        b = at::cat({b.slice(1, 0, 2), b.slice(1, 1, 3)}, 2).relu();
        const auto c = at::conv2d(b.unsqueeze(0), at::ones({4, 2, 2, 2}, on.options()) / 3).squeeze(0);
        const auto index = at::arange(2, on.options().dtype(at::kLong));
        auto d = c.flatten(1).t().index_select(0, index).mm(c.flatten(1)).sum();
        auto e = at::zeros({5}, on.options());
        e.narrow(0, 1, 2).add_(3).mul_(2);
        d = d + e.sum() + fresco::ordered_sum(c * c);
        const auto gradient = torch::autograd::grad({d}, {a})[0];
        return std::pair(d.detach().cpu(), gradient.cpu());
    };
    const auto near = work(x);
    const auto far = work(x.to(far_device()));
    CHECK(at::allclose(near.first, far.first, 1e-6));
    CHECK(at::allclose(near.second, far.second, 1e-6));
}

TEST_CASE("the far device counts what a processor would wait for and refuses to mix")
{
    const auto x = at::ones({3}, at::kFloat).to(far_device());
    forget_far_traffic();
    const auto y = (x + 1) * x.sum();
    CHECK(far_traffic().wait_count() == 0);
    CHECK(y.sum().item<float>() == 18);
    CHECK(far_traffic().wait_count() == 1);
    CHECK((x > 0).nonzero().size(0) == 3);
    CHECK(far_traffic().wait_count() == 2);
    CHECK(x.index({x > 0}).size(0) == 3);
    CHECK(far_traffic().wait_count() > 2);
    CHECK(at::ones({2}).to(far_device()).size(0) == 2);
    CHECK(far_traffic().to_device == 1);
    CHECK(at::ones({2}).to(far_device(), at::kFloat, true).size(0) == 2);
    CHECK(far_traffic().to_device_later == 1);
    CHECK_THROWS(x + at::ones({3}));
    CHECK_THROWS_WITH(x.unsqueeze(0).mm(at::ones({3, 3})), Catch::Contains("both sides"));
}
