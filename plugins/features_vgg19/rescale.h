#pragma once

#include "vgg19.h"

#include <string_view>
#include <vector>

/// \file Bringing weights to the scale of Simonyan and Zisserman's own activations. StyleMesh's λ hold only for these: a Gram
/// loss grows with the fourth power of the activations, a content loss with the second.

namespace vgg19
{

/// The network whose input is BGR in 0..255 minus its mean color and whose layers answer as those of `network` do: order of
/// channels, scale, mean and deviation are folded into the first convolution. A border of zeros stays the mean color.
Vgg19 folded(const Vgg19& network);

/// The mean activation of each layer over all filters and places, averaged over `pictures` (RGB in [0,1], 3 x H x W). In a fixed
/// order.
std::vector<double> mean_activations(const Vgg19& network, const std::vector<torch::Tensor>& pictures);

/// The network with the activations of layer i multiplied by factors[i] > 0. Exact, since rectifier, pooling and padding commute
/// with a factor: weights are multiplied by their layer's and divided by that of the layer that they read.
Vgg19 scaled(const Vgg19& network, const std::vector<double>& factors);

/// The raw network's mean activation in a layer such as "relu3_1". Layers without a known figure take that of the closest earlier
/// layer that has one.
double raw_mean(std::string_view layer);

struct Rescaled
{
    Vgg19 network;
    std::vector<double> means;  ///< Before, per layer.
};

/// `network` folded and scaled to the raw network's means over `pictures`. Throws fresco::Error if a layer is silent on all
/// pictures or there are no pictures.
Rescaled rescaled(const Vgg19& network, const std::vector<torch::Tensor>& pictures);

}  // namespace vgg19
