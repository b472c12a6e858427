#pragma once

/// \file Gram matrices of features as tensors with a gradient, and their average over recent views.

#include <fresco/torch/loss.h>

#include <torch/types.h>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace gram
{

/// F·Fᵀ / N of `features` (C x N, float32 or float64, N >= 1): the Gram matrix divided by the number of features (StyleMesh,
/// section 3.4); differentiable. Sums run over fixed blocks in a fixed order, so the result and the gradient are the same for any
/// thread count.
torch::Tensor gram_matrix(const torch::Tensor& features);

/// The matrix of all features and that of the first `fine_count` of them; the second is missing if none is fine. Equals
/// gram_matrix() of each, for less work: what both share is multiplied once, forward and back.
struct GramOfBoth
{
    torch::Tensor all;
    std::optional<torch::Tensor> fine;
};
GramOfBoth gram_of_both(const torch::Tensor& features, std::int64_t fine_count);

/// The factors of products in gram_distance(); float64, on the CPU. They depend only on the view: another device needs them once
/// a visit. `scale`: factor of every squared difference.
torch::Tensor gram_weights(const std::vector<fresco::LevelColumns>& levels, bool has_fine_target, double scale);

/// Sums, over the levels with their shares, the squared differences of all features' Gram matrix and of that of the fine ones,
/// where there are any, each to its target. Differentiable. `features`: the levels' columns side by side, at least one.
/// `targets`: that of all and that of the fine ones, if there is one, C x C each. `weights`: gram_weights() in the features' type
/// and place.
torch::Tensor gram_distance(const torch::Tensor& features, const std::vector<fresco::LevelColumns>& levels,
                            const torch::Tensor& targets, const torch::Tensor& weights);

/// mean over elements of (a - b)².
torch::Tensor mean_square_difference(const torch::Tensor& a, const torch::Tensor& target);

/// The mean of the matrices of the last visits to views, kept apart by name (level, layer, pixels). Consecutive steps on one view
/// are one visit, of which the last step counts.
class ViewAverage
{
  public:
    /// `count` >= 1 visits, the current one among them.
    explicit ViewAverage(int count) : count_(count) {}

    /// Position of a step in the run.
    struct Visit
    {
        std::int64_t step = 0;
        std::int64_t view = 0;
        std::int64_t repeat = 0;
    };

    /// The mean of `current` and of the up to `count` - 1 visits before it, as `current` in type and device. Gradients flow
    /// only through `current`. Remembers `current`; a second call for the same step replaces the first.
    torch::Tensor average(const std::string& name, const Visit& visit, const torch::Tensor& current);

    fresco::TensorMap state() const;
    /// Throws Error for a state that state() did not make.
    void restore(const fresco::TensorMap& state);

  private:
    struct Kept
    {
        std::int64_t step = 0;
        std::int64_t view = 0;
        torch::Tensor matrix;
    };

    int count_;
    std::map<std::string, std::deque<Kept>> kept_;  ///< Oldest first; the newest is the current visit's.
};

}  // namespace gram
