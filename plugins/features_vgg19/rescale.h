#pragma once

#include "vgg19.h"

#include <string_view>
#include <vector>

/// \file Bringing weights to the scale of Simonyan and Zisserman's own activations. StyleMesh's λ hold only for these: a Gram
/// loss grows with the fourth power of the activations, a content loss with the second (METHOD section 10).

namespace vgg19
{

/// The network whose input is BGR in 0..255 minus its mean colour and whose layers answer as those of `network` do: order of
/// channels, scale, mean and deviation are folded into the first convolution. A border of zeros stays the mean colour.
Vgg19 folded(const Vgg19& network);

/// The mean activation of each layer over all filters and places, averaged over `pictures` (RGB in [0,1], 3 x H x W). In a fixed
/// order.
std::vector<double> mean_activations(const Vgg19& network, const std::vector<torch::Tensor>& pictures);

/// The network with the activations of layer i multiplied by factors[i] > 0. Exact, since rectifier, pooling and padding commute
/// with a factor: weights are multiplied by their layer's and divided by that of the layer that they read.
Vgg19 scaled(const Vgg19& network, const std::vector<double>& factors);

/// What a layer such as "relu3_1" of the raw network answers with on average; of layers without a known figure, that of the last
/// one before that has one.
double raw_mean(std::string_view layer);

struct Rescaled
{
    Vgg19 network;
    std::vector<double> means;  ///< Before, per layer.
};

/// `network` folded and scaled to the raw network's means over `pictures`. Throws fresco::Error where a layer is silent on all
/// pictures, or where there are none.
Rescaled rescaled(const Vgg19& network, const std::vector<torch::Tensor>& pictures);

}  // namespace vgg19
