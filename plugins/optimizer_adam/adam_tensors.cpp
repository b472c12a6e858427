#include "adam_tensors.h"

#include <ATen/ATen.h>

#include <cmath>

namespace fresco::adam
{

void step_dense(TensorBlock& block, const torch::Tensor& texels, const torch::Tensor& gradient, std::int64_t step, double rate,
                double pull, const Constants& constants)
{
    const auto t = static_cast<double>(step);
    const auto all = (block.values * pull).index_add_(0, texels, gradient);
    block.first.mul_(constants.beta1).add_(all, 1 - constants.beta1);
    block.second.mul_(constants.beta2).addcmul_(all, all, 1 - constants.beta2);
    const auto root = (block.second / (1 - std::pow(constants.beta2, t))).sqrt_().add_(constants.epsilon);
    block.values.addcdiv_(block.first, root, -rate / (1 - std::pow(constants.beta1, t)));
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
