#pragma once

#include <fresco/torch/texture_representation.h>

namespace fresco::optimize
{

/// The sum of two gradients of one parameter: the union of their texels, ascending; where both have a texel, a's value plus b's.
SparseGradient sparse_sum(const SparseGradient& a, const SparseGradient& b);

}  // namespace fresco::optimize
