#include <fresco/torch/style_layers.h>

#include <fresco/error.h>
#include <fresco/random.h>
#include <fresco/torch/tensor.h>

#include <ATen/core/grad_mode.h>
#include <ATen/ops/empty.h>
#include <ATen/ops/index_copy.h>
#include <ATen/ops/zeros.h>
#include <torch/csrc/autograd/custom_function.h>

namespace fresco
{
namespace
{

/// Its own derivative: torch adds up the gradient of index_select column by column, these columns are unique.
struct Columns : torch::autograd::Function<Columns>
{
    static at::Tensor forward(torch::autograd::AutogradContext* context, const at::Tensor& values, const at::Tensor& columns)
    {
        context->save_for_backward({columns});
        context->saved_data["count"] = values.size(1);
        return values.index_select(1, columns);
    }

    static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                   torch::autograd::variable_list gradients)
    {
        const auto columns = context->get_saved_variables()[0];
        const auto zeros = at::zeros({gradients[0].size(0), context->saved_data["count"].toInt()}, gradients[0].options());
        return {zeros.index_copy(1, columns, gradients[0]), at::Tensor()};
    }
};

}  // namespace

StyleOptions::StyleOptions(Configurable* owner)
    : features(owner, "features", "features.dictionary", "Network whose features are compared"),
      layers(owner, "layers", "", "Layers to compare, such as \"relu1_1, relu2_1\"; empty: the network's own choice for styles"),
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
        throw Error(std::string(loss) + ": `layer_weights` has " + std::to_string(layer_weights->size()) + " entries for " +
                    std::to_string(result.size()) + " layers; give one for each, or none");
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
            throw Error(std::string(loss) + ": the style picture (" + std::to_string(picture.size(2)) + " x " +
                        std::to_string(picture.size(1)) + ") is too small for layer " + layers[features.size()].name +
                        ": use a larger picture or fewer layers");
        features.push_back(map.flatten(1));
    }
    return features;
}

torch::Tensor sampled_columns(const torch::Tensor& features, std::int64_t most, std::uint64_t seed)
{
    const auto count = features.size(1);
    if (count <= most)
        return features;
    Random random(seed);
    auto columns = at::empty({most}, at::kLong);
    for (std::int64_t i = 0; i < most; ++i)
    {
        const auto begin = i * count / most;
        columns.data_ptr<std::int64_t>()[i] = begin + random.below((i + 1) * count / most - begin);
    }
    return Columns::apply(features, sent_to(columns, features.device()));
}

StyleFeatureLoss::~StyleFeatureLoss() = default;

LossNeeds StyleFeatureLoss::needs() const
{
    return options_.needs(compared_);
}

void StyleFeatureLoss::prepare(const PrepareContext& context)
{
    const at::NoGradGuard no_gradient;
    compared_ = options_.compared(loss_);
    targets_.assign(compared_.size(), {});
    Random random(context.seed);
    for (const auto& role : options_.roles(context.style))
    {
        const auto features = style_features(*options_.features, role.picture, compared_, loss_);
        for (std::size_t i = 0; i < features.size(); ++i)
            targets_[i].push_back({role.pixels, target_of(features[i], random.bits())});
    }
}

std::vector<LossTerm> StyleFeatureLoss::evaluate(Part& part)
{
    std::vector<LossTerm> terms;
    Random random(part.seed());
    for (std::size_t i = 0; i < compared_.size(); ++i)
    {
        torch::Tensor sum;
        for (const auto& target : targets_[i])
        {
            const auto seed = random.bits();
            const auto features = part.selected(*options_.features, compared_[i].name, target.pixels);
            if (features.size(1) == 0)
                continue;
            const auto value = distance(features, target.value, seed);
            sum = sum.defined() ? sum + value : value;
        }
        if (sum.defined())
            terms.push_back({compared_[i].name, sum * compared_[i].factor, &*options_.features});
    }
    return terms;
}

}  // namespace fresco
