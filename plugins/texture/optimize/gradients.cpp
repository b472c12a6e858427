#include "gradients.h"

#include <ATen/ops/_unique2.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/zeros.h>

#include <cstddef>
#include <limits>
#include <vector>

namespace fresco::optimize
{
namespace
{

torch::Tensor shown(const ValueSpace& space, const torch::Tensor& stored)
{
    if (!space.is_network())
        return stored;
    auto values = stored.flip(0);
    for (std::size_t c = 0; c < 3; ++c)
        values.select(0, static_cast<std::int64_t>(c)).add_(space.offset(c));
    return values.div_(255);
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
        // How far a value lies outside, with its sign: a step against the gradient leads on where that has the other one.
        const auto value = shown(space, stored);
        result.masked_fill_((value - value.clamp(0, 1)) * gradient < 0, 0);
    }
    return (space.is_network() ? result.flip(0) : result).contiguous();
}

SparseGradient sparse_sum(const SparseGradient& a, const SparseGradient& b)
{
    constexpr auto none = std::numeric_limits<std::int64_t>::max();
    const auto count_a = a.texels.numel();
    const auto count_b = b.texels.numel();
    const auto texels = at::empty({count_a + count_b}, at::kLong);
    const auto values = at::empty({count_a + count_b, 3}, at::kFloat);
    const auto* texel_a = a.texels.data_ptr<std::int64_t>();
    const auto* texel_b = b.texels.data_ptr<std::int64_t>();
    const auto* value_a = a.values.data_ptr<float>();
    const auto* value_b = b.values.data_ptr<float>();
    auto* texel = texels.data_ptr<std::int64_t>();
    auto* value = values.data_ptr<float>();
    std::int64_t count = 0;
    for (std::int64_t i = 0, j = 0; i < count_a || j < count_b; ++count)
    {
        const auto next_a = i < count_a ? texel_a[i] : none;
        const auto next_b = j < count_b ? texel_b[j] : none;
        const bool use_a = next_a <= next_b;
        const bool use_b = next_b <= next_a;
        texel[count] = use_a ? next_a : next_b;
        for (std::int64_t c = 0; c < 3; ++c)
            value[3 * count + c] = (use_a ? value_a[3 * i + c] : 0.0F) + (use_b ? value_b[3 * j + c] : 0.0F);
        i += use_a ? 1 : 0;
        j += use_b ? 1 : 0;
    }
    return {texels.narrow(0, 0, count), values.narrow(0, 0, count)};
}

namespace
{

bool are_same(const std::vector<torch::Tensor>& merged, const std::vector<std::vector<SparseGradient>>& levels,
              std::size_t parameter)
{
    if (merged.size() != levels.size())
        return false;
    for (std::size_t level = 0; level < levels.size(); ++level)
        if (!merged[level].is_same(levels[level][parameter].texels))
            return false;
    return true;
}

}  // namespace

GradientUnion::Merged& GradientUnion::merged(const std::vector<std::vector<SparseGradient>>& levels, std::size_t parameter)
{
    auto& known = parameters_[parameter];
    if (are_same(known.of_levels, levels, parameter))
        return known;
    known = {};
    for (const auto& level : levels)
        known.of_levels.push_back(level[parameter].texels);
    const auto [texels, places, counts] = at::_unique2(at::cat(known.of_levels), true, true, false);
    known.texels = texels;
    std::int64_t begin = 0;
    for (const auto& of_level : known.of_levels)
    {
        known.places.push_back(places.narrow(0, begin, of_level.numel()));
        begin += of_level.numel();
    }
    return known;
}

std::vector<SparseGradient> GradientUnion::sum(const std::vector<std::vector<SparseGradient>>& levels)
{
    if (levels.size() == 1)
        return levels[0];
    parameters_.resize(levels[0].size());
    std::vector<SparseGradient> result;
    for (std::size_t parameter = 0; parameter < levels[0].size(); ++parameter)
    {
        const auto& all = merged(levels, parameter);
        auto values = at::zeros({all.texels.numel(), 3}, levels[0][parameter].values.options());
        // One level after the other, each texel once: the same sums whatever the order on the device.
        for (std::size_t level = 0; level < levels.size(); ++level)
            values.index_add_(0, all.places[level], levels[level][parameter].values);
        result.push_back({all.texels, values});
    }
    return result;
}

}  // namespace fresco::optimize
