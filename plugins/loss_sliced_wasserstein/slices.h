#pragma once

#include <torch/types.h>

#include <cstdint>

namespace sliced
{

/// `count` unit vectors of `dimensions` (count x dimensions, of `options`), drawn by `seed` alike in all directions.
torch::Tensor random_directions(std::int64_t count, std::int64_t dimensions, std::uint64_t seed,
                                const torch::TensorOptions& options);

/// Each row of `values` (K x N, float32 or float64) in ascending order.
torch::Tensor sorted_rows(const torch::Tensor& values);

/// For every entry of `values` (K x N) the entry of the same rank in the row of `sorted` (K x M, ascending, M >= 1), which is
/// stretched to N entries by interpolation: rank r is at (r + 0.5) M / N - 0.5, clamped to the ends. No gradient.
torch::Tensor of_same_rank(const torch::Tensor& values, const torch::Tensor& sorted);

/// The sliced Wasserstein distance of two sets of points, `features` (C x N, N >= 1, differentiable) and `target` (C x M), along
/// `directions` (K x C): the mean over directions and points of the squared difference of equal ranks (Heitz et al. 2021,
/// equation 4). The same bytes for any thread count.
torch::Tensor distance(const torch::Tensor& features, const torch::Tensor& target, const torch::Tensor& directions);

}  // namespace sliced
