#pragma once

#include <fresco/torch/loss.h>

#include <torch/types.h>

#include <string>
#include <string_view>
#include <vector>

/// \file What losses that compare features with the style picture do alike. `loss` is the loss's type, named in errors.

namespace fresco
{

/// A layer that is compared, and the factor of its term.
struct StyleLayer
{
    std::string name;
    double factor = 1;
};
std::vector<std::string> names_of(const std::vector<StyleLayer>& layers);

/// One size of the style picture and the pixels of a part that are compared with it (StyleMesh, section 3.3).
struct StyleRole
{
    Pixels pixels;
    torch::Tensor picture;
};

/// Options that such losses share; a member of the loss.
struct StyleOptions
{
    explicit StyleOptions(Configurable* owner);

    Slot<FeatureNetwork> features;
    Option<std::string> layers;
    Option<std::vector<double>> layer_weights;
    Option<std::string> targets;

    /// The layers named, or the network's own for styles where none are, with their factors; the network is prepared. Throws
    /// Error for unknown layers, a wrong number of factors, a network without layers for styles.
    std::vector<StyleLayer> compared(std::string_view loss) const;
    /// Selected features of `compared`; of the layers named, where it is empty.
    LossNeeds needs(const std::vector<StyleLayer>& compared) const;
    /// The coarse picture on all pixels, the fine one on those that pass the angle filter, as `targets` says.
    std::vector<StyleRole> roles(const StylePictures& style) const;
};

/// The features of `picture` in each of the layers, C x N with N >= 1; no gradient. Throws Error where the picture is too small.
std::vector<torch::Tensor> style_features(const FeatureNetwork& network, const torch::Tensor& picture,
                                          const std::vector<StyleLayer>& layers, std::string_view loss);

}  // namespace fresco
