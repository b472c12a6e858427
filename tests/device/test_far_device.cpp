#include "far_device.h"

#include <ATen/ATen.h>

#include "catch.h"

using fresco::testing::far_device;
using fresco::testing::far_traffic;
using fresco::testing::forget_far_traffic;

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
    at::ones({2}).to(far_device());
    at::ones({2}).to(far_device(), at::kFloat, true);
    CHECK(far_traffic().to_device == 1);
    CHECK(far_traffic().to_device_later == 1);
    CHECK_THROWS_WITH(x.unsqueeze(0).mm(at::ones({3, 3})), Contains("both sides"));
}
