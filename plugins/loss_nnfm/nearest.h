#pragma once

#include <torch/types.h>

namespace nnfm
{

/// Each row of `rows` (N x C, float32 or float64) divided by its length; a row of zeros stays one.
torch::Tensor unit_rows(const torch::Tensor& rows);

/// For each row of `queries` (N x C, unit rows) the row of `style` (M x C, unit rows, M >= 1) with the largest cosine, the first
/// of equals: N, int64. Products are made in blocks: memory does not grow with N · M. The same for any thread count.
torch::Tensor most_similar(const torch::Tensor& queries, const torch::Tensor& style);

/// Mean over the columns of `features` (C x N, N >= 1, differentiable) of 1 - cos to the style row that is most similar to each
/// (Zhang et al. 2022, equation 2). Which row that is takes no part in the gradient.
torch::Tensor distance(const torch::Tensor& features, const torch::Tensor& style);

}  // namespace nnfm
