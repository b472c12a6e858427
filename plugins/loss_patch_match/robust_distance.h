#pragma once

#include "patches.h"

#include <torch/types.h>

namespace patch_match
{

/// Mean over patches of (|patch - style patch|² / scale + 1e-4)^(exponent / 2): a norm that lets a patch keep a few pixels of its
/// own. Kwatra et al., Texture optimization for example-based synthesis, 2005, section 3.2.
/// `picture` 3 x H x W of the grid's size, float32 or float64, differentiable; `nearest` int32, per patch of the grid a row of
/// `style` (N x 147, float32) or -1 for a patch that takes no part; `scale` > 0. The empty tensor where no patch takes part.
/// The same for any number of `threads`.
torch::Tensor robust_distance(const torch::Tensor& picture, const PatchGrid& grid, const torch::Tensor& nearest,
                              const torch::Tensor& style, double scale, double exponent, int threads);

}  // namespace patch_match
