#include "sparse_sum.h"

#include <ATen/ops/empty.h>

#include <limits>

namespace fresco::optimize
{

SparseGradient sparse_sum(const SparseGradient& a, const SparseGradient& b)
{
    constexpr auto none = std::numeric_limits<std::int64_t>::max();
    const auto count_a = a.texels.numel();
    const auto count_b = b.texels.numel();
    const auto texels = at::empty({count_a + count_b}, at::kLong);
    const auto values = at::empty({count_a + count_b, 3}, at::kFloat);
    const auto* texel_a = a.texels.data_ptr<std::int64_t>();
    const auto* texel_b = b.texels.data_ptr<std::int64_t>();
    const auto* value_a = a.values.data_ptr<float>();
    const auto* value_b = b.values.data_ptr<float>();
    auto* texel = texels.data_ptr<std::int64_t>();
    auto* value = values.data_ptr<float>();
    std::int64_t count = 0;
    for (std::int64_t i = 0, j = 0; i < count_a || j < count_b; ++count)
    {
        const auto next_a = i < count_a ? texel_a[i] : none;
        const auto next_b = j < count_b ? texel_b[j] : none;
        const bool use_a = next_a <= next_b;
        const bool use_b = next_b <= next_a;
        texel[count] = use_a ? next_a : next_b;
        for (std::int64_t c = 0; c < 3; ++c)
            value[3 * count + c] = (use_a ? value_a[3 * i + c] : 0.0F) + (use_b ? value_b[3 * j + c] : 0.0F);
        i += use_a ? 1 : 0;
        j += use_b ? 1 : 0;
    }
    return {texels.narrow(0, 0, count), values.narrow(0, 0, count)};
}

}  // namespace fresco::optimize
