#pragma once

#include <fresco/progress.h>
#include <fresco/random.h>

#include <torch/types.h>

namespace dictionary
{

/// Unit vectors (K x D) that stand for the directions of `samples` (N x D, float32, N >= 1): `iterations` rounds of giving every
/// sample to the centre with the largest dot product and moving each centre to the direction of its samples' sum. Starts from
/// seeded samples; a centre without samples takes the sample that fits its own centre worst. K may exceed N.
/// Coates and Ng, Learning Feature Representations with K-means, 2012. Deterministic for any thread count.
torch::Tensor spherical_k_means(const torch::Tensor& samples, int centres, int iterations, fresco::Random& random,
                                fresco::Progress& progress);

}  // namespace dictionary
