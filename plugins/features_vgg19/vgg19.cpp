#include "vgg19.h"

#include <ATen/ATen.h>

#include <algorithm>
#include <utility>

namespace vgg19
{
namespace
{

using fresco::weights::Vgg19Padding;

torch::Tensor to_tensor(const fresco::weights::TensorView& view, std::string_view source)
{
    const auto values = fresco::weights::to_float32(view, source);
    const std::vector<std::int64_t> shape(view.shape.begin(), view.shape.end());
    auto tensor = at::empty(shape, at::kFloat);
    std::copy(values.begin(), values.end(), tensor.data_ptr<float>());
    return tensor;
}

torch::Tensor padded(const torch::Tensor& maps, Vgg19Padding padding)
{
    const std::vector<std::int64_t> sides{1, 1, 1, 1};
    if (padding == Vgg19Padding::zero)
        return at::constant_pad_nd(maps, sides);
    // A side of one pixel has nothing to reflect: that pixel goes on.
    const auto side = [&](int dimension, std::vector<std::int64_t> at_it, const torch::Tensor& of)
    { return of.size(dimension) > 1 ? at::reflection_pad2d(of, at_it) : at::replication_pad2d(of, at_it); };
    if (std::min(maps.size(2), maps.size(3)) > 1)
        return at::reflection_pad2d(maps, sides);
    return side(2, {0, 0, 1, 1}, side(3, {1, 1, 0, 0}, maps));
}

torch::Tensor pooled(const torch::Tensor& maps, Pooling pooling)
{
    const auto height = maps.size(2) / 2;
    const auto width = maps.size(3) / 2;
    if (height == 0 || width == 0)
        return maps.new_empty({1, maps.size(1), height, width});
    return pooling == Pooling::max ? at::max_pool2d(maps, {2, 2}) : at::avg_pool2d(maps, {2, 2});
}

}  // namespace

std::vector<Convolution> convolutions(const fresco::weights::Vgg19Weights& weights, std::string_view source)
{
    std::vector<Convolution> result;
    for (const auto& layer : weights.layers)
        result.push_back({"relu" + layer.name, to_tensor(layer.weight, source), to_tensor(layer.bias, source), layer.pooled});
    return result;
}

Vgg19::Vgg19(std::vector<Convolution> layers, const fresco::weights::Vgg19Input& input, Pooling pooling)
    : convolutions_(std::move(layers)), on_cpu_(std::make_shared<CpuEncoder>(convolutions_, input, pooling)), input_(input),
      pooling_(pooling)
{
}

void Vgg19::move_to(const torch::Device& device)
{
    for (auto& convolution : convolutions_)
    {
        convolution.weights = convolution.weights.to(device);
        convolution.bias = convolution.bias.to(device);
    }
}

std::vector<fresco::FeatureLayer> Vgg19::layers() const
{
    std::vector<fresco::FeatureLayer> result;
    int stride = 1;
    int margin = 0;
    for (const auto& convolution : convolutions_)
    {
        if (convolution.pooled)
            stride *= 2;
        margin += stride;
        fresco::FeatureLayer layer;
        layer.name = convolution.layer;
        layer.channels = static_cast<int>(convolution.weights.size(0));
        layer.stride = stride;
        layer.margin_px = margin;
        layer.style = convolution.layer.ends_with("_1");
        layer.content = convolution.layer == "relu4_2";
        result.push_back(layer);
    }
    const bool has_content = std::any_of(result.begin(), result.end(), [](const auto& layer) { return layer.content; });
    if (!has_content && !result.empty())
        result.back().content = true;
    return result;
}

torch::Tensor Vgg19::network_input(const torch::Tensor& picture) const
{
    std::vector<torch::Tensor> channels;
    for (std::size_t i = 0; i < 3; ++i)
    {
        const auto channel = picture[static_cast<std::int64_t>(input_.bgr ? 2 - i : i)];
        channels.push_back((channel * input_.scale - input_.mean[i]) / input_.deviation[i]);
    }
    return at::stack(channels).unsqueeze(0);
}

std::vector<torch::Tensor> Vgg19::encode(const torch::Tensor& picture, const std::vector<std::string>& names) const
{
    std::vector<std::size_t> wanted;
    for (std::size_t i = 0; i < convolutions_.size(); ++i)
        if (std::find(names.begin(), names.end(), convolutions_[i].layer) != names.end())
            wanted.push_back(i);
    if (wanted.empty() || !CpuEncoder::takes(picture, convolutions_, wanted.back()))
        return encode_generally(picture, names);
    const auto maps = on_cpu_->encode(picture, wanted);
    std::vector<torch::Tensor> result;
    for (const auto& name : names)
        for (std::size_t i = 0; i < wanted.size(); ++i)
            if (convolutions_[wanted[i]].layer == name)
                result.push_back(maps[i]);
    return result;
}

std::vector<torch::Tensor> Vgg19::encode_generally(const torch::Tensor& picture, const std::vector<std::string>& names) const
{
    std::vector<torch::Tensor> result(names.size());
    std::size_t missing = names.size();
    auto maps = network_input(picture);
    for (const auto& convolution : convolutions_)
    {
        if (missing == 0)
            break;
        if (convolution.pooled)
            maps = pooled(maps, pooling_);
        if (maps.size(2) == 0 || maps.size(3) == 0)
            maps = maps.new_empty({1, convolution.weights.size(0), maps.size(2), maps.size(3)});
        else
            maps = at::relu(at::conv2d(padded(maps, input_.padding), convolution.weights.to(maps.options()),
                                       convolution.bias.to(maps.options())));
        for (std::size_t i = 0; i < names.size(); ++i)
            if (names[i] == convolution.layer)
            {
                result[i] = maps.squeeze(0);
                --missing;
            }
    }
    return result;
}

}  // namespace vgg19
