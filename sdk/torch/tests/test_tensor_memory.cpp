#include <fresco/torch/tensor_memory.h>

#include <ATen/ops/arange.h>
#include <ATen/ops/equal.h>
#include <ATen/ops/full.h>
#include <torch/types.h>

#include <vector>

// Last: libtorch's headers bring a macro CHECK of their own.
#include "catch.h"

using namespace fresco;

#if defined(__linux__)
namespace
{

constexpr std::int64_t megabyte = 1 << 20;

torch::Tensor filled(std::int64_t megabytes, int value)
{
    return at::full({megabytes * megabyte}, value, at::kChar);
}

bool holds(const torch::Tensor& tensor, int value)
{
    return at::equal(tensor, at::full(tensor.sizes(), value, at::kChar));
}

}  // namespace

TEST_CASE("tensors of other sizes get the pages of those that are gone")
{
    reuse_tensor_memory();
    // What the checks compare with takes memory too, once.
    CHECK(holds(filled(64, 1), 1));
    const std::size_t before = reused_tensor_bytes();
    for (int round = 0; round < 3; ++round)
    {
        std::vector<torch::Tensor> kept;
        for (int i = 0; i < 8; ++i)
            kept.push_back(filled(4, i));
        // Holes between tensors that stay, none as large as what comes.
        for (const std::size_t i : {0U, 2U, 4U, 6U})
            kept[i] = torch::Tensor();
        const auto large = filled(16, 9);
        CHECK(reused_tensor_bytes() == before);
        CHECK(large.eq(9).all().item<bool>());
        for (const int i : {1, 3, 5, 7})
            CHECK(kept[static_cast<std::size_t>(i)].eq(i).all().item<bool>());
    }
}

TEST_CASE("small and empty tensors are tensors as ever")
{
    reuse_tensor_memory();
    const std::size_t before = reused_tensor_bytes();
    CHECK(at::arange(10).sum().item<std::int64_t>() == 45);
    CHECK(filled(0, 1).numel() == 0);
    CHECK(reused_tensor_bytes() == before);
}
#endif
