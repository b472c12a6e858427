#include "device_view.h"

#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace fresco
{
namespace
{

template <class To, class From>
torch::Tensor as_tensor(const std::vector<From>& values, at::ScalarType type)
{
    auto tensor = at::empty({std::ssize(values)}, type);
    std::copy(values.begin(), values.end(), tensor.template data_ptr<To>());
    return tensor;
}

/// Where coordinates in [0,1] fall between the texels of one axis: the first (int32) and the share of the one after it.
std::pair<torch::Tensor, torch::Tensor> place(const torch::Tensor& coordinate, int size, TexelGrid grid)
{
    const auto texels = grid == TexelGrid::centers ? coordinate * size - 0.5 : coordinate * (size - 1);
    const auto x = texels.clamp(0, size - 1);
    const auto first = x.to(at::kInt).clamp_max(size - 2);
    return {first, x - first};
}

}  // namespace

DeviceView::Layer DeviceView::layer(const torch::Tensor& uv, const torch::Tensor& values, int size, TexelGrid grid)
{
    const auto [column, right] = place(uv.select(1, 0), size, grid);
    const auto [row, down] = place(1 - uv.select(1, 1), size, grid);
    Layer result;
    result.size = size;
    result.values = values;
    result.base = row * size + column;
    result.right = right.unsqueeze(1);
    result.down = down.unsqueeze(1);

    const auto& base = result.base;
    const auto texels = at::stack({base, base + 1, base + size, base + (size + 1)}, 1).flatten();
    const auto left = 1 - right;
    const auto up = 1 - down;
    const auto weights = at::stack({left * up, right * up, left * down, right * down}, 1).flatten();
    const auto used = (weights > 0).nonzero().flatten();
    const auto [sorted, order] = at::sort(texels.index_select(0, used), true, 0, false);
    const auto lookups = used.index_select(0, order);
    const auto [touched, inverse, counts] = at::unique_consecutive(sorted, false, true, 0);
    result.texels = touched.to(at::kLong);
    result.offsets = at::cat({at::zeros({1}, counts.options()), counts.cumsum(0)});
    result.pixels = lookups.div(4, "floor").to(at::kInt);
    result.weights = weights.index_select(0, lookups).unsqueeze(1);
    return result;
}

DeviceView::DeviceView(const UvMap& map, const std::vector<TextureParameter>& parameters, const std::vector<int>& sizes,
                       TexelGrid grid)
{
    const auto valid = valid_pixels(map);
    width_ = valid.width;
    height_ = valid.height;
    const auto device = parameters.at(0).values.device();
    pixels_ = sent_to(as_tensor<std::int64_t>(valid.pixels, at::kLong), device);
    const auto uv = sent_to(as_tensor<float>(valid.uv, at::kFloat), device).view({-1, 2});
    for (std::size_t i = 0; i < sizes.size(); ++i)
        layers_.push_back(layer(uv, parameters[i].values, sizes[i], grid));
}

torch::Tensor DeviceView::render() const
{
    const at::NoGradGuard no_gradient;
    auto sums = at::zeros({pixels_.numel(), 3}, pixels_.options().dtype(at::kFloat));
    for (const auto& layer : layers_)
    {
        const auto left = 1 - layer.right;
        const auto row = [&](int below)
        {
            const auto upper = layer.base + below;
            return layer.values.index_select(0, upper).mul_(left).add_(layer.values.index_select(0, upper + 1).mul_(layer.right));
        };
        sums.add_(row(0).mul_(1 - layer.down).add_(row(layer.size).mul_(layer.down)));
    }
    return at::zeros({3, height_ * width_}, sums.options()).index_copy_(1, pixels_, sums.t()).view({3, height_, width_});
}

std::vector<SparseGradient> DeviceView::gradient(const torch::Tensor& picture_gradient) const
{
    const at::NoGradGuard no_gradient;
    if (picture_gradient.dim() != 3 || picture_gradient.size(0) != 3 || picture_gradient.size(1) != height_ ||
        picture_gradient.size(2) != width_)
        throw std::invalid_argument("the gradient of a view has the shape of its picture, 3 x H x W");
    const auto at_pixels =
        sent_to(picture_gradient.to(at::kFloat), pixels_.device()).reshape({3, -1}).index_select(1, pixels_).t().contiguous();
    std::vector<SparseGradient> result;
    for (const auto& layer : layers_)
    {
        const auto shares = at_pixels.index_select(0, layer.pixels).mul_(layer.weights);
        // Without its checks, which would have to wait. One sum after the other within a texel, so that no order is left open.
        result.push_back({layer.texels, at::segment_reduce(shares, "sum", {}, {}, layer.offsets, 0, true)});
    }
    return result;
}

}  // namespace fresco
