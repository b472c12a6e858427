#pragma once

#include "adam.h"

#include <torch/types.h>

#include <cstdint>

/// \file Adam by libtorch's operators, for other devices than the CPU: the same as adam.h's to some 1e-6, without waiting.

namespace fresco::adam
{

struct TensorBlock
{
    torch::Tensor values;  ///< N x 3; changed in place, as the moments and
    torch::Tensor first;
    torch::Tensor second;
    torch::Tensor steps;  ///< N, int32: how often each texel was changed; only for step_visible.
};

/// \see step_dense of a Block. `texels` (n, int64, each once) and `gradient` (n x 3): where it is not zero.
void step_dense(TensorBlock& block, const torch::Tensor& texels, const torch::Tensor& gradient, std::int64_t step, double rate,
                double pull, const Constants& constants);
/// \see step_visible of a Block.
void step_visible(TensorBlock& block, const torch::Tensor& texels, const torch::Tensor& gradient, double rate, double pull,
                  const Constants& constants);

}  // namespace fresco::adam
