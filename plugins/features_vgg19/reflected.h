#pragma once

#include <torch/types.h>

namespace vgg19
{

/// 1 x C x H x W maps with one pixel more on each side: reflected, or repeated where a side has only one pixel. Of any type, on
/// any device; channels are innermost in memory before and after, unlike with libtorch's own on CUDA. Differentiable once.
torch::Tensor reflected(const torch::Tensor& maps);

}  // namespace vgg19
