#pragma once

#include "value_space.h"

#include <torch/types.h>

#include <span>

namespace fresco::optimize
{

/// Of a contiguous float32 tensor on the CPU, which must outlive it.
inline std::span<float> values_of(const torch::Tensor& tensor)
{
    return {tensor.data_ptr<float>(), static_cast<std::size_t>(tensor.numel())};
}

/// What ValueSpace does, by libtorch on any device and as a few operators. \see ValueSpace::display: 3 x H x W of `stored` (3 x H
/// x W) and `valid` (H x W, bool).
torch::Tensor displayed_values(const ValueSpace& space, const torch::Tensor& stored, const torch::Tensor& valid);
/// \see ValueSpace::back: d loss / d stored of `gradient` (d loss / d displayed) and `factor` (H x W).
torch::Tensor values_back(const ValueSpace& space, const torch::Tensor& stored, const torch::Tensor& factor,
                          const torch::Tensor& gradient);

}  // namespace fresco::optimize
