#include "adam.h"

#include <fresco/parallel.h>

#include <ATen/ATen.h>
#include <torch/version.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace fresco::adam
{
namespace
{

constexpr std::size_t texels_per_piece = 16384;
static_assert(texels_per_piece % texels_per_run == 0, "a flag belongs to one piece");

/// Factors that depend on the constants and the number of a step.
struct Factors
{
    float step_size;     ///< rate / (1 - beta1^t)
    float second_scale;  ///< 1 / (1 - beta2^t)
};

Factors factors(std::int64_t step, double rate, const Constants& constants)
{
    const auto t = static_cast<double>(step);
    return {static_cast<float>(rate / (1 - std::pow(constants.beta1, t))),
            static_cast<float>(1 / (1 - std::pow(constants.beta2, t)))};
}

class Stepper
{
  public:
    Stepper(const Block& block, double pull, const Constants& constants)
        : block_(block), pull_(static_cast<float>(pull)), beta1_(static_cast<float>(constants.beta1)),
          keep1_(static_cast<float>(1 - constants.beta1)), beta2_(static_cast<float>(constants.beta2)),
          keep2_(static_cast<float>(1 - constants.beta2)), epsilon_(static_cast<float>(constants.epsilon))
    {
    }

    /// Steps `count` numbers from the block's number `begin` on.
    void step(std::size_t begin, std::size_t count, const float* __restrict gradient, const Factors& f) const
    {
        float* __restrict values = block_.values + begin;
        float* __restrict first = block_.first + begin;
        float* __restrict second = block_.second + begin;
        for (std::size_t i = 0; i < count; ++i)
        {
            const float g = gradient[i] + pull_ * values[i];
            first[i] = beta1_ * first[i] + keep1_ * g;
            second[i] = beta2_ * second[i] + keep2_ * g * g;
            values[i] -= f.step_size * first[i] / (std::sqrt(second[i] * f.second_scale) + epsilon_);
        }
    }

  private:
    Block block_;
    float pull_;
    float beta1_;
    float keep1_;
    float beta2_;
    float keep2_;
    float epsilon_;
};

bool differs_from_zero(const float* values, std::size_t texels)
{
    return std::any_of(values, values + 3 * texels, [](float value) { return value != 0; });
}

}  // namespace

void mark_moved(const Block& block, int threads)
{
    parallel_for(block.texels, texels_per_piece, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t first = begin; first < end; first += texels_per_run)
                     {
                         const std::size_t count = std::min(texels_per_run, end - first);
                         const bool moved = differs_from_zero(block.values + 3 * first, count) ||
                                            differs_from_zero(block.first + 3 * first, count) ||
                                            differs_from_zero(block.second + 3 * first, count);
                         block.moved[first / texels_per_run] = moved ? 1 : 0;
                     }
                 });
}

void step_dense(const Block& block, const Gradient& gradient, std::int64_t step, double rate, double pull,
                const Constants& constants, int threads)
{
    const Stepper stepper(block, pull, constants);
    const Factors f = factors(step, rate, constants);
    parallel_for(block.texels, texels_per_piece, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     auto next =
                         std::lower_bound(gradient.texels.begin(), gradient.texels.end(), static_cast<std::int64_t>(begin));
                     for (std::size_t first = begin; first < end; first += texels_per_run)
                     {
                         const std::size_t last = std::min(end, first + texels_per_run);
                         const bool given_any = next != gradient.texels.end() && *next < static_cast<std::int64_t>(last);
                         if (block.moved != nullptr)
                         {
                             auto& moved = block.moved[first / texels_per_run];
                             if (moved == 0 && !given_any)
                                 continue;
                             moved = 1;
                         }
                         std::array<float, 3 * texels_per_run> all{};
                         for (; next != gradient.texels.end() && *next < static_cast<std::int64_t>(last); ++next)
                             std::copy_n(gradient.values + 3 * (next - gradient.texels.begin()), 3,
                                         all.data() + 3 * (*next - static_cast<std::int64_t>(first)));
                         stepper.step(3 * first, 3 * (last - first), all.data(), f);
                     }
                 });
}

void step_visible(const Block& block, const Gradient& gradient, double rate, double pull, const Constants& constants, int threads)
{
    const Stepper stepper(block, pull, constants);
    std::int32_t most = 0;
    for (const auto texel : gradient.texels)
        most = std::max(most, block.steps[texel]);
    // pow per texel would cost more than the step itself.
    std::vector<Factors> by_step{Factors{}};
    for (std::int64_t step = 1; step <= std::int64_t{most} + 1; ++step)
        by_step.push_back(factors(step, rate, constants));
    parallel_for(gradient.texels.size(), texels_per_piece, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t entry = begin; entry < end; ++entry)
                     {
                         const auto texel = static_cast<std::size_t>(gradient.texels[entry]);
                         const std::int32_t step = ++block.steps[texel];
                         stepper.step(3 * texel, 3, gradient.values + 3 * entry, by_step[static_cast<std::size_t>(step)]);
                     }
                 });
}

void step_dense(const std::vector<TensorBlock>& blocks, const std::vector<SparseGradient>& gradients,
                const std::vector<double>& pulls, std::int64_t step, double rate, const Constants& constants)
{
    std::vector<torch::Tensor> values;
    std::vector<torch::Tensor> firsts;
    std::vector<torch::Tensor> seconds;
    for (const auto& block : blocks)
    {
        values.push_back(block.values);
        firsts.push_back(block.first);
        seconds.push_back(block.second);
    }
    auto all = at::_foreach_mul(values, std::vector<at::Scalar>(pulls.begin(), pulls.end()));
    for (std::size_t i = 0; i < blocks.size(); ++i)
        all[i].index_add_(0, gradients[i].texels, gradients[i].values);
#if TORCH_VERSION_MAJOR >= 2
    // In one pass over the texels.
    if (values.front().is_cuda())
    {
        const std::vector<torch::Tensor> steps(blocks.size(), at::full({}, static_cast<double>(step), values.front().options()));
        at::_fused_adam_(values, all, firsts, seconds, {}, steps, rate, constants.beta1, constants.beta2, 0, constants.epsilon,
                         false, false);
        return;
    }
#endif
    const auto t = static_cast<double>(step);
    at::_foreach_mul_(firsts, constants.beta1);
    at::_foreach_add_(firsts, all, 1 - constants.beta1);
    at::_foreach_mul_(seconds, constants.beta2);
    at::_foreach_addcmul_(seconds, all, all, 1 - constants.beta2);
    // The root of the second moment's correction is taken out of the fraction.
    const double correction = std::sqrt(1 - std::pow(constants.beta2, t));
    auto roots = at::_foreach_sqrt(seconds);
    at::_foreach_add_(roots, constants.epsilon * correction);
    at::_foreach_addcdiv_(values, firsts, roots, -rate * correction / (1 - std::pow(constants.beta1, t)));
}

void step_visible(TensorBlock& block, const torch::Tensor& texels, const torch::Tensor& gradient, double rate, double pull,
                  const Constants& constants)
{
    const auto values = block.values.index_select(0, texels);
    const auto all = gradient + values * pull;
    const auto first = block.first.index_select(0, texels).mul_(constants.beta1).add_(all, 1 - constants.beta1);
    const auto second = block.second.index_select(0, texels).mul_(constants.beta2).addcmul_(all, all, 1 - constants.beta2);
    const auto steps = block.steps.index_select(0, texels).add_(1);
    const auto t = steps.to(at::kDouble);
    const auto step_size = (rate / (1 - at::pow(constants.beta1, t))).to(at::kFloat).unsqueeze(1);
    const auto scale = (1 / (1 - at::pow(constants.beta2, t))).to(at::kFloat).unsqueeze(1);
    block.values.index_copy_(0, texels, values - step_size * first / ((second * scale).sqrt_().add_(constants.epsilon)));
    block.first.index_copy_(0, texels, first);
    block.second.index_copy_(0, texels, second);
    block.steps.index_copy_(0, texels, steps);
}

}  // namespace fresco::adam
