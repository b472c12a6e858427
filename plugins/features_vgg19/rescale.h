#pragma once

#include "vgg19.h"

#include <vector>

/// \file Bringing other weights to the scale of Gatys' (Gatys et al., 2016, section 2): λ of a loss holds for these alone,
/// because a Gram loss grows with the fourth power of the activations.

namespace vgg19
{

/// What gets a mean activation of 1.
enum class UnitMean
{
    of_layers,
    of_filters  ///< Of each filter, as Gatys did, and so of the layer.
};

/// The network whose input is BGR in 0..255 minus its mean colour and whose layers answer as those of `network` do: order of
/// channels, scale, mean and deviation are folded into the first convolution. A border of zeros stays the mean colour.
Vgg19 folded(const Vgg19& network);

/// The mean activation of each layer's filters (K, double) over all places, averaged over `pictures` (RGB in [0,1], 3 x H x W).
/// In a fixed order.
std::vector<torch::Tensor> mean_activations(const Vgg19& network, const std::vector<torch::Tensor>& pictures);

/// The network with the activations of layer i's filters multiplied by factors[i] (K, double, > 0). Exact, since rectifier,
/// pooling and padding commute with a factor: a weight is multiplied by its filter's and divided by that of the filter that it
/// reads.
Vgg19 scaled(const Vgg19& network, const std::vector<torch::Tensor>& factors);

/// `network` folded and scaled to means of 1 over `pictures`. A filter that answers with less than a twentieth of its layer's
/// mean is scaled as if it had that, lest noise become the style. Throws fresco::Error where a layer is silent on all pictures,
/// or where there are none.
Vgg19 with_unit_means(const Vgg19& network, const std::vector<torch::Tensor>& pictures, UnitMean unit);

}  // namespace vgg19
