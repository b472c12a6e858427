#include "sparse_sum.h"

#include "catch.h"

#include <ATen/ops/empty.h>

#include <vector>

using namespace fresco;
using namespace fresco::optimize;

namespace
{

SparseGradient sparse(const std::vector<std::int64_t>& texels)
{
    SparseGradient g{at::empty({static_cast<std::int64_t>(texels.size())}, at::kLong),
                     at::empty({static_cast<std::int64_t>(texels.size()), 3}, at::kFloat)};
    for (std::size_t i = 0; i < texels.size(); ++i)
    {
        g.texels.data_ptr<std::int64_t>()[i] = texels[i];
        for (std::size_t c = 0; c < 3; ++c)
            g.values.data_ptr<float>()[3 * i + c] = static_cast<float>(texels[i]) + static_cast<float>(c) / 10;
    }
    return g;
}

}  // namespace

TEST_CASE("sparse gradients add by texel")
{
    const auto sum = sparse_sum(sparse({1, 4, 9}), sparse({0, 4, 12}));
    const std::vector<std::int64_t> texels(sum.texels.data_ptr<std::int64_t>(),
                                           sum.texels.data_ptr<std::int64_t>() + sum.texels.numel());
    CHECK(texels == std::vector<std::int64_t>{0, 1, 4, 9, 12});
    CHECK(sum.values[2][1].item<float>() == Approx(8.2));
    CHECK(sum.values[4][0].item<float>() == 12);
    CHECK(sparse_sum(sparse({}), sparse({3})).texels.numel() == 1);
    CHECK(sparse_sum(sparse({}), sparse({})).texels.numel() == 0);
}
