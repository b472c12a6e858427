#include <fresco/torch/style_layers.h>

#include <fresco/error.h>

#include <ATen/core/grad_mode.h>

#include <fmt/format.h>

namespace fresco
{

StyleOptions::StyleOptions(Configurable* owner)
    : features(owner, "features", "features.vgg19", "Network whose features are compared"),
      layers(owner, "layers", "", "Layers to compare, such as \"relu1_1, relu2_1\"; empty: the network's own choice for style"),
      layer_weights(owner, "layer_weights", std::vector<double>{}, at_least(0),
                    "Factor of each layer, in the order of layers; empty: 1 each"),
      targets(
          owner, "targets", "fine", one_of({"fine", "coarse", "both"}),
          "Which size of the style picture: fine (256 px) on pixels that pass the angle filter, coarse (up to 4 times as large) "
          "on all pixels, or both")
{
}

std::vector<StyleLayer> StyleOptions::compared(std::string_view loss) const
{
    std::vector<StyleLayer> result;
    for (auto& name : split_layer_names(*layers))
        result.push_back({std::move(name)});
    if (result.empty())
        for (const auto& layer : features->layers())
            if (layer.style)
                result.push_back({layer.name});
    for (const auto& layer : result)
        features->layer(layer.name);
    if (result.empty())
        throw Error(std::string(loss) + ": the network of `features` has no layer meant for styles; name some in `layers`");
    if (!layer_weights->empty() && layer_weights->size() != result.size())
        throw Error(fmt::format("{}: `layer_weights` has {} entries for {} layers; give one for each, or none", loss,
                                layer_weights->size(), result.size()));
    for (std::size_t i = 0; i < layer_weights->size(); ++i)
        result[i].factor = (*layer_weights)[i];
    return result;
}

LossNeeds StyleOptions::needs(const std::vector<StyleLayer>& compared) const
{
    LossNeeds needs;
    needs.features.push_back({.network = &*features,
                              .names = compared.empty() ? split_layer_names(*layers) : names_of(compared),
                              .whole = false,
                              .camera = false});
    return needs;
}

std::vector<StyleRole> StyleOptions::roles(const StylePictures& style) const
{
    std::vector<StyleRole> roles;
    if (*targets != "fine")
        roles.push_back({Pixels::all, style.coarse});
    if (*targets != "coarse")
        roles.push_back({Pixels::fine, style.fine});
    return roles;
}

std::vector<std::string> names_of(const std::vector<StyleLayer>& layers)
{
    std::vector<std::string> names;
    for (const auto& layer : layers)
        names.push_back(layer.name);
    return names;
}

std::vector<torch::Tensor> style_features(const FeatureNetwork& network, const torch::Tensor& picture,
                                          const std::vector<StyleLayer>& layers, std::string_view loss)
{
    const at::NoGradGuard no_gradient;
    std::vector<torch::Tensor> features;
    for (const auto& map : network.encode(picture, names_of(layers)))
    {
        if (map.numel() == 0)
            throw Error(
                fmt::format("{}: the style picture ({} x {}) is too small for layer {}: use a larger picture or fewer layers",
                            loss, picture.size(2), picture.size(1), layers[features.size()].name));
        features.push_back(map.flatten(1));
    }
    return features;
}

}  // namespace fresco
