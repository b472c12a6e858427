#pragma once

#include <torch/types.h>

namespace dictionary
{

/// x -> transform · (x - mean) has covariance close to the identity.
struct Whitening
{
    torch::Tensor mean;       ///< D
    torch::Tensor transform;  ///< D x D
};

/// Whitening of samples (N x D, float32) with `epsilon` times the mean eigenvalue added to every eigenvalue of the covariance.
/// The transform is the inverse Cholesky factor: it differs from PCA whitening by a rotation alone, so lengths and angles after
/// it, all that k-means on the sphere looks at, are the same. Deterministic for any thread count. N >= 2.
Whitening learn_whitening(const torch::Tensor& samples, double epsilon);

}  // namespace dictionary
