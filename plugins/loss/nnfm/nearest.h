#pragma once

/// \file Nearest-neighbor feature matching: the style's features, thinned out, and the nearest of them for each of a picture's.

#include <torch/types.h>

#include <cstdint>

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

/// At most `most` of the columns of `features` (C x N), differentiable: one from each of `most` equal runs of columns, drawn by
/// `seed`, in their order. All of them where N <= most; `most` >= 1.
torch::Tensor sampled_columns(const torch::Tensor& features, std::int64_t most, std::uint64_t seed);

}  // namespace nnfm
