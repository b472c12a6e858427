#include "value_tensors.h"

#include <ATen/ops/stack.h>

#include <cstddef>
#include <vector>

namespace fresco::optimize
{
namespace
{

torch::Tensor shown(const ValueSpace& space, const torch::Tensor& stored)
{
    if (!space.is_network())
        return stored;
    std::vector<torch::Tensor> channels;
    for (std::size_t c = 0; c < 3; ++c)
        channels.push_back((stored.select(0, static_cast<std::int64_t>(space.plane_of(c))) + space.offset(c)) / 255);
    return at::stack(channels);
}

}  // namespace

torch::Tensor displayed_values(const ValueSpace& space, const torch::Tensor& stored, const torch::Tensor& valid)
{
    const auto all = shown(space, stored);
    return (space.is_clamped() ? all.clamp(0, 1) : all).masked_fill(valid.logical_not(), 0);
}

torch::Tensor values_back(const ValueSpace& space, const torch::Tensor& stored, const torch::Tensor& factor,
                          const torch::Tensor& gradient)
{
    auto result = gradient * (factor * space.scale());
    if (space.is_clamped())
    {
        const auto value = shown(space, stored);
        const auto leads_on = ((value < 0).logical_and(gradient > 0)).logical_or((value > 1).logical_and(gradient < 0));
        result.masked_fill_(leads_on, 0);
    }
    return space.is_network() ? result.flip(0) : result;
}

}  // namespace fresco::optimize
