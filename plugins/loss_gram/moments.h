#pragma once

#include <fresco/torch/loss.h>

#include <torch/types.h>

#include <optional>

namespace gram
{

/// First and second moments of features.
struct Moments
{
    torch::Tensor mean;    ///< C
    torch::Tensor second;  ///< C x C: F·Fᵀ / N, the Gram matrix divided by the number of features (StyleMesh, section 3.4)
};

/// Of `features` (C x N, float32 or float64, N >= 1); differentiable. Sums run over fixed blocks in a fixed order, so the result
/// and the gradient are the same for any thread count.
Moments moments(const torch::Tensor& features);

/// Of all features and of those that `columns` says are fine; the second is missing if no column is fine. The same as moments()
/// of each, for less work: what both share is multiplied once, forward and back.
struct MomentsOfBoth
{
    Moments all;
    std::optional<Moments> fine;
};
MomentsOfBoth moments_of_both(const torch::Tensor& features, const fresco::FineColumns& columns);

/// second - mean·meanᵀ.
torch::Tensor covariance(const Moments& moments);

/// mean over elements of (a - b)².
torch::Tensor mean_square_difference(const torch::Tensor& a, const torch::Tensor& target);

/// Σ (a - target)² / Σ target². A target of zeros counts as one of length 1.
torch::Tensor relative_square_difference(const torch::Tensor& a, const torch::Tensor& target);

}  // namespace gram
