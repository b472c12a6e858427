#include "vgg19.h"

#include "reflected.h"

#include <ATen/ATen.h>
#include <torch/csrc/autograd/autograd.h>

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

/// Maps, or a convolution's weights as its maps have them: else libtorch turns them each time.
torch::Tensor laid_out(const torch::Tensor& values, Order order = Order::channels_innermost)
{
    return values.contiguous(order == Order::channels_innermost ? at::MemoryFormat::ChannelsLast : at::MemoryFormat::Contiguous);
}

torch::Tensor framed(const torch::Tensor& maps, Order order)
{
    // libtorch's own has nothing to reflect in a side of one pixel.
    const bool own = order == Order::channels_innermost || maps.size(2) < 2 || maps.size(3) < 2;
    return own ? reflected(maps) : at::reflection_pad2d(maps, {1, 1, 1, 1});
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
    for (auto* layers : {&convolutions_, &halves_})
        for (auto& convolution : *layers)
        {
            convolution.weights = laid_out(convolution.weights.to(device));
            convolution.bias = convolution.bias.to(device);
        }
}

void Vgg19::set_precision(Precision precision)
{
    halves_.clear();
    if (precision == Precision::full)
        return;
    halves_ = convolutions_;
    for (auto& convolution : halves_)
    {
        convolution.weights = laid_out(convolution.weights.to(at::kBFloat16));
        convolution.bias = convolution.bias.to(at::kBFloat16);
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

std::vector<torch::Tensor> Vgg19::encode_generally(const torch::Tensor& picture, const std::vector<std::string>& names,
                                                   Order order) const
{
    std::vector<torch::Tensor> result(names.size());
    std::size_t missing = names.size();
    auto maps = laid_out(network_input(picture), order);
    for (std::size_t number = 0; number < convolutions_.size() && missing > 0; ++number)
    {
        if (convolutions_[number].pooled)
            maps = pooled(maps, pooling_);
        maps = responses(number, maps, order);
        for (std::size_t i = 0; i < names.size(); ++i)
            if (names[i] == convolutions_[number].layer)
            {
                result[i] = maps.to(picture.scalar_type()).squeeze(0);
                --missing;
            }
    }
    return result;
}

torch::Tensor Vgg19::responses(std::size_t number, const torch::Tensor& maps, Order order) const
{
    // The first layer costs next to nothing, and bfloat16 would round 0..255 to whole numbers.
    const bool half = !halves_.empty() && number > 0 && maps.scalar_type() != at::kDouble;
    const auto input = half ? maps.to(at::kBFloat16) : maps;
    const auto& convolution = half ? halves_[number] : convolutions_[number];
    if (input.size(2) == 0 || input.size(3) == 0)
        return input.new_empty({1, convolution.weights.size(0), input.size(2), input.size(3)});
    const bool reflect = input_.padding == Vgg19Padding::reflect;
    return at::relu(at::conv2d(reflect ? framed(input, order) : input, laid_out(convolution.weights.to(input.options()), order),
                               convolution.bias.to(input.options()), 1, reflect ? 0 : 1));
}

bool convolves_bfloat16(const torch::Device& device)
{
    try
    {
        const auto options = torch::TensorOptions(device).dtype(at::kBFloat16);
        const auto maps = laid_out(at::ones({1, 16, 8, 8}, options)).set_requires_grad(true);
        const auto sum = at::conv2d(maps, laid_out(at::ones({16, 16, 3, 3}, options)), at::zeros({16}, options), 1, 1).sum();
        return torch::autograd::grad({sum}, {maps})[0].sum().item<double>() > 0;
    }
    catch (const c10::Error&)
    {
        return false;
    }
}

}  // namespace vgg19
