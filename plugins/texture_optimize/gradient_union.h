#pragma once

#include <fresco/torch/texture_representation.h>

#include <vector>

namespace fresco::optimize
{

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
        std::vector<torch::Tensor> of_levels;  ///< What was merged.
        torch::Tensor texels;                  ///< Of any level, ascending.
        std::vector<torch::Tensor> places;     ///< Of each level's texels among them.
    };
    Merged& merged(const std::vector<std::vector<SparseGradient>>& levels, std::size_t parameter);

    std::vector<Merged> parameters_;
};

}  // namespace fresco::optimize
