#pragma once

#include <torch/types.h>

#include <cstdint>

namespace nnfm
{

/// At most `most` of the columns of `features` (C x N), differentiable: one from each of `most` equal runs of columns, drawn by
/// `seed`, in their order. All of them where N <= most; `most` >= 1.
torch::Tensor sampled_columns(const torch::Tensor& features, std::int64_t most, std::uint64_t seed);

}  // namespace nnfm
