// Destructors and defaults of the tensor contracts: their type information lives in this library.

#include <fresco/abi.h>
#include <fresco/error.h>
#include <fresco/plugin.h>
#include <fresco/torch/features.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/optimizer_rule.h>
#include <fresco/torch/texture_representation.h>

#include <ATen/core/grad_mode.h>
#include <torch/version.h>

#include <algorithm>
#include <boost/algorithm/string.hpp>
#include <fmt/format.h>

namespace fresco
{

FeatureNetwork::~FeatureNetwork() = default;
PartialFeatures::~PartialFeatures() = default;
SheetFeatures::~SheetFeatures() = default;
Part::~Part() = default;
Levels::~Levels() = default;
Loss::~Loss() = default;
JointLoss::~JointLoss() = default;
TextureView::~TextureView() = default;
TextureRepresentation::~TextureRepresentation() = default;
OptimizerRule::~OptimizerRule() = default;

FeatureLayer FeatureNetwork::layer(const std::string& name) const
{
    std::string known;
    for (const auto& candidate : layers())
    {
        if (candidate.name == name)
            return candidate;
        known += (known.empty() ? "" : ", ") + candidate.name;
    }
    throw Error("the feature network has no layer '" + name + "'; it has: " + known);
}

bool TextureRepresentation::move_to(const torch::Device& device)
{
    return device.is_cpu();
}

bool OptimizerRule::runs_on(const torch::Device& device) const
{
    return device.is_cpu();
}

TensorMap Loss::state() const
{
    return {};
}

void Loss::restore(const TensorMap& state)
{
    if (!state.empty())
        throw Error("the checkpoint holds '" + state.begin()->first +
                    "' for a loss that remembers nothing; remove the checkpoint folder");
}

std::vector<std::string> split_layer_names(std::string_view list)
{
    std::vector<std::string> words, names;
    boost::split(words, list, boost::is_any_of(", \t\n"));
    for (std::string& word : words)
        if (!word.empty() && std::ranges::find(names, word) == names.end())
            names.push_back(std::move(word));
    return names;
}

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

// The build properties of this library, for the host's handshake: a plugin that uses tensors must have the same.
extern "C" __attribute__((visibility("default"))) const fresco_plugin_info* fresco_sdk_torch_info_1();

const fresco_plugin_info* fresco_sdk_torch_info_1()
{
    static constexpr fresco_plugin_info info{
        FRESCO_MAGIC,  FRESCO_ABI,       FRESCO_COMPILER_STAMP, FRESCO_STANDARD_LIBRARY_STAMP, FRESCO_CONTAINERS_STAMP,
        TORCH_VERSION, FRESCO_TORCH_CUDA};
    return &info;
}
