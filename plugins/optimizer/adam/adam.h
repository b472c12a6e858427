#pragma once

/// \file Adam (Kingma and Ba, ICLR 2015, algorithm 1) on blocks of N texels of 3 values, for gradients that are known for few
/// texels; and by libtorch's operators for other devices than the CPU, the same to some 1e-6, without waiting.

#include <fresco/torch/texture_representation.h>

#include <torch/types.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fresco::adam
{

struct Constants
{
    double beta1;
    double beta2;
    double epsilon;
};

/// Values and what Adam remembers of them; 3 N floats each.
struct Block
{
    float* values = nullptr;
    float* first = nullptr;         ///< Moving mean of the gradient.
    float* second = nullptr;        ///< Moving mean of its square.
    std::int32_t* steps = nullptr;  ///< N: how many steps each texel has had; used only by step_visible.
    std::size_t texels = 0;
    std::uint8_t* moved = nullptr;  ///< run_count(texels) flags, or null; used only by step_dense, see mark_moved.
};

/// Texels that share a flag `moved`. Few, so that little outside a chart is stepped; flags are a thousandth of the values.
constexpr std::size_t texels_per_run = 128;
constexpr std::size_t run_count(std::size_t texels)
{
    return (texels + texels_per_run - 1) / texels_per_run;
}

/// Sets block.moved to 1 for the runs in which a value or a moment differs from zero, to 0 for all others.
void mark_moved(const Block& block, int threads);

/// Gradient values (3 per entry) on `texels`, ascending and unique.
struct Gradient
{
    std::span<const std::int64_t> texels;
    const float* values = nullptr;
};

/// One textbook step, the `step`-th (from 1), of every texel: no entry means gradient 0. `pull` times the value is added to the
/// gradient (the derivative of a regularizer). Results do not depend on `threads`.
///
/// Where nothing but zero has ever been, Adam's step is zero: with block.moved, runs that have no flag and no entry are neither
/// read nor written, and the results are the same bytes. Runs with an entry get their flag.
void step_dense(const Block& block, const Gradient& gradient, std::int64_t step, double rate, double pull,
                const Constants& constants, int threads);

/// Steps only the texels of `gradient`: the others' values, moments and step counts stay. Each texel's bias correction
/// counts its own steps, so every texel takes the textbook's steps as if only its own steps had happened.
void step_visible(const Block& block, const Gradient& gradient, double rate, double pull, const Constants& constants,
                  int threads);

struct TensorBlock
{
    torch::Tensor values;  ///< N x 3; changed in place, as the moments and
    torch::Tensor first;
    torch::Tensor second;
    torch::Tensor steps;  ///< N, int32: how often each texel was changed; only for step_visible.
};

/// \see step_dense of a Block; all blocks together, each with its gradient and its pull.
void step_dense(const std::vector<TensorBlock>& blocks, const std::vector<SparseGradient>& gradients,
                const std::vector<double>& pulls, std::int64_t step, double rate, const Constants& constants);
/// \see step_visible of a Block. `texels` (n, int64, each once) and `gradient` (n x 3).
void step_visible(TensorBlock& block, const torch::Tensor& texels, const torch::Tensor& gradient, double rate, double pull,
                  const Constants& constants);

}  // namespace fresco::adam
