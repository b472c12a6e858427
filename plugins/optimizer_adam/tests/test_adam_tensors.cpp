#include "adam_tensors.h"

#include <far_device.h>

#include <ATen/ATen.h>

#include "catch.h"

using namespace fresco::adam;

TEST_CASE("Adam on another device steps as on the processor")
{
    constexpr std::int64_t texels = 40;
    const Constants constants{0.9, 0.99, 1e-8};
    for (const bool visible : {true, false})
    {
        CAPTURE(visible);
        const auto values = at::sin(at::arange(3 * texels, at::kFloat)).view({texels, 3});
        const auto near = values.clone();
        const auto first = at::zeros_like(near);
        const auto second = at::zeros_like(near);
        const auto steps = at::zeros({texels}, at::kInt);
        const Block block{near.data_ptr<float>(), first.data_ptr<float>(), second.data_ptr<float>(),
                          steps.data_ptr<std::int32_t>(), texels};
        const auto device = fresco::testing::far_device();
        TensorBlock there{values.to(device), first.to(device), second.to(device), steps.to(device)};
        for (std::int64_t step = 1; step <= 6; ++step)
        {
            const auto touched = at::arange(step % 3, texels, step, at::kLong);
            const auto gradient = at::cos(at::arange(3 * touched.numel(), at::kFloat)).view({-1, 3}) * step;
            const Gradient sparse{{touched.data_ptr<std::int64_t>(), static_cast<std::size_t>(touched.numel())},
                                  gradient.data_ptr<float>()};
            const auto far_touched = touched.to(device);
            const auto far_gradient = gradient.to(device);
            fresco::testing::forget_far_traffic();
            if (visible)
            {
                step_visible(block, sparse, 0.1, 0.02, constants, 2);
                step_visible(there, far_touched, far_gradient, 0.1, 0.02, constants);
            }
            else
            {
                step_dense(block, sparse, step, 0.1, 0.02, constants, 2);
                step_dense(there, far_touched, far_gradient, step, 0.1, 0.02, constants);
            }
            CHECK(fresco::testing::far_traffic().wait_count() == 0);
        }
        CHECK(at::allclose(there.values.cpu(), near, 1e-5, 1e-6));
        CHECK(at::allclose(there.second.cpu(), second, 1e-5, 1e-6));
        CHECK(at::allclose(there.first.cpu(), first, 1e-5, 1e-6));
        if (visible)
            CHECK(there.steps.cpu().equal(steps));
        CHECK((near - values).abs().max().item<float>() > 0.1);
    }
}
