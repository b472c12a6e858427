#pragma once

/// \file The way from the losses' gradient of a displayed picture back to the texels that it shows. For evaluation.cpp and
/// views.h.

#include "pictures.h"

#include <fresco/torch/texture_representation.h>

#include <torch/types.h>

#include <vector>

namespace fresco::optimize
{

/// The displayed values of `stored` (3 x H x W): 0 where `valid` (H x W, bool) is false. On any device, as a few operators.
torch::Tensor displayed_values(const ValueSpace& space, const torch::Tensor& stored, const torch::Tensor& valid);
/// The derivative of the above: `gradient` (3 x H x W, d loss / d displayed) times `factor` (H x W) to d loss / d stored. Inside
/// the displayable range all of it passes; outside only where a step against the gradient leads back, so that no texel is stuck
/// beyond the range. Contiguous.
torch::Tensor values_back(const ValueSpace& space, const torch::Tensor& stored, const torch::Tensor& factor,
                          const torch::Tensor& gradient);

/// The sum of two gradients of one parameter: the union of their texels, ascending; where both have a texel, a's value plus b's.
SparseGradient sparse_sum(const SparseGradient& a, const SparseGradient& b);

/// Sums the gradients of a view's levels on another device than the CPU. Which texels they share is found out once, at the price
/// of waiting for the device, and again where other texels come.
class GradientUnion
{
  public:
    /// `levels`: per level, one entry per parameter; at least one level.
    std::vector<SparseGradient> sum(const std::vector<std::vector<SparseGradient>>& levels);

  private:
    struct Merged
    {
        std::vector<torch::Tensor> of_levels;  ///< The merged gradients.
        torch::Tensor texels;                  ///< Texels of all levels, ascending.
        std::vector<torch::Tensor> places;     ///< Positions of each level's texels among them.
    };
    Merged& merged(const std::vector<std::vector<SparseGradient>>& levels, std::size_t parameter);

    std::vector<Merged> parameters_;
};

}  // namespace fresco::optimize
