#include "rescale.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <cmath>
#include <utility>

namespace vgg19
{

Vgg19 folded(const Vgg19& network)
{
    const auto& from = network.input();
    fresco::weights::Vgg19Input to;
    to.bgr = true;
    to.scale = 255;
    to.padding = from.padding;
    auto layers = network.convolutions();
    const auto old_weights = layers.front().weights.to(at::kDouble);
    auto new_weights = at::empty_like(old_weights);
    for (std::size_t blue_first = 0; blue_first < 3; ++blue_first)
    {
        const std::size_t channel = from.bgr ? blue_first : 2 - blue_first;
        // x_old = (scale · c - mean) / deviation and x_new = 255 · c - 255 · mean / scale, so x_old = x_new · scale / (255 ·
        // deviation).
        to.mean[blue_first] = from.mean[channel] * 255 / from.scale;
        new_weights.select(1, static_cast<std::int64_t>(blue_first))
            .copy_(old_weights.select(1, static_cast<std::int64_t>(channel)) * (from.scale / (255 * from.deviation[channel])));
    }
    layers.front().weights = new_weights.to(at::kFloat);
    return {std::move(layers), to, network.pooling()};
}

std::vector<torch::Tensor> mean_activations(const Vgg19& network, const std::vector<torch::Tensor>& pictures)
{
    const at::NoGradGuard no_gradient;
    std::vector<std::string> names;
    std::vector<torch::Tensor> means;
    for (const auto& layer : network.convolutions())
    {
        names.push_back(layer.layer);
        means.push_back(at::zeros({layer.bias.size(0)}, layer.bias.options().dtype(at::kDouble)));
    }
    for (const auto& picture : pictures)
    {
        const auto maps = network.encode(picture, names);
        for (std::size_t i = 0; i < maps.size(); ++i)
            means[i] += fresco::ordered_mean(maps[i].flatten(1).to(at::kDouble), 1) / static_cast<double>(pictures.size());
    }
    return means;
}

Vgg19 scaled(const Vgg19& network, const std::vector<torch::Tensor>& factors)
{
    auto layers = network.convolutions();
    for (std::size_t i = 0; i < layers.size(); ++i)
    {
        auto weights = layers[i].weights.to(at::kDouble) * factors[i].view({-1, 1, 1, 1});
        if (i > 0)
            weights = weights / factors[i - 1].view({1, -1, 1, 1});
        layers[i].weights = weights.to(at::kFloat);
        layers[i].bias = (layers[i].bias.to(at::kDouble) * factors[i]).to(at::kFloat);
    }
    return {std::move(layers), network.input(), network.pooling()};
}

Vgg19 with_unit_means(const Vgg19& network, const std::vector<torch::Tensor>& pictures, UnitMean unit)
{
    constexpr double faintest = 0.05;
    if (pictures.empty())
        throw fresco::Error("features.vgg19: weights that are not normalised are rescaled by what they make of the style and the "
                            "frames, but there is no picture; give weights that are normalised, or `rescale: never`");
    const Vgg19 common = folded(network);
    std::vector<torch::Tensor> factors;
    for (const auto& means : mean_activations(common, pictures))
    {
        const auto mean = fresco::ordered_mean(means);
        if (const double value = mean.item<double>(); !(value > 0) || !std::isfinite(value))
            throw fresco::Error("features.vgg19: layer " + common.convolutions()[factors.size()].layer +
                                " is silent on the style and on all frames, so it cannot be rescaled to a mean activation of 1; "
                                "give the weights of a trained VGG-19");
        auto own = at::ones_like(means) / mean;
        if (unit == UnitMean::of_filters)
        {
            own = 1 / at::max(means, mean * faintest);
            own = own / fresco::ordered_mean(means * own);
        }
        factors.push_back(own);
    }
    return scaled(common, factors);
}

}  // namespace vgg19
