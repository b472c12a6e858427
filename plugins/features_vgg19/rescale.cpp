#include "rescale.h"

#include <fresco/error.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

#include <array>
#include <cmath>
#include <utility>

namespace vgg19
{
namespace
{

/// By the losses that a run of Gatys' method with the original weights printed; layers in the network's order.
constexpr std::array<std::pair<std::string_view, double>, 6> raw_means{
    {{"relu1_1", 21}, {"relu2_1", 83}, {"relu3_1", 76}, {"relu4_1", 320}, {"relu4_2", 390}, {"relu5_1", 27}}};

}  // namespace

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

std::vector<double> mean_activations(const Vgg19& network, const std::vector<torch::Tensor>& pictures)
{
    const at::NoGradGuard no_gradient;
    std::vector<std::string> names;
    for (const auto& layer : network.convolutions())
        names.push_back(layer.layer);
    std::vector<double> means(names.size(), 0.0);
    for (const auto& picture : pictures)
    {
        const auto maps = network.encode(picture, names);
        for (std::size_t i = 0; i < maps.size(); ++i)
            means[i] += fresco::ordered_mean(maps[i].to(at::kDouble)).item<double>() / static_cast<double>(pictures.size());
    }
    return means;
}

Vgg19 scaled(const Vgg19& network, const std::vector<double>& factors)
{
    auto layers = network.convolutions();
    for (std::size_t i = 0; i < layers.size(); ++i)
    {
        const double before = i > 0 ? factors[i - 1] : 1;
        layers[i].weights = (layers[i].weights.to(at::kDouble) * (factors[i] / before)).to(at::kFloat);
        layers[i].bias = (layers[i].bias.to(at::kDouble) * factors[i]).to(at::kFloat);
    }
    return {std::move(layers), network.input(), network.pooling()};
}

double raw_mean(std::string_view layer)
{
    double mean = 0;
    for (const auto& [name, value] : raw_means)
        if (name <= layer)
            mean = value;
    return mean;
}

Rescaled rescaled(const Vgg19& network, const std::vector<torch::Tensor>& pictures)
{
    if (pictures.empty())
        throw fresco::Error("features.vgg19: these weights are rescaled by the style and the frames, but there is no picture; "
                            "use raw weights, or set `rescale: false`");
    const Vgg19 common = folded(network);
    const auto means = mean_activations(common, pictures);
    std::vector<double> factors;
    for (std::size_t i = 0; i < means.size(); ++i)
    {
        const std::string& layer = common.convolutions()[i].layer;
        if (!(means[i] > 0) || !std::isfinite(means[i]))
            throw fresco::Error(
                "features.vgg19: layer " + layer +
                " is zero on the style and on all frames, so it cannot be rescaled; use the weights of a trained VGG-19");
        factors.push_back(raw_mean(layer) / means[i]);
    }
    return {scaled(common, factors), means};
}

}  // namespace vgg19
