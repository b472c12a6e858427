#include "gradient_union.h"

#include <ATen/ops/_unique2.h>
#include <ATen/ops/cat.h>
#include <ATen/ops/zeros.h>

namespace fresco::optimize
{
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
