#include "moments.h"

#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>

#include <ATen/ATen.h>
#include <torch/version.h>

#include <array>
#include <utility>

namespace
{

class LossGram final : public fresco::Loss
{
    fresco::Slot<fresco::FeatureNetwork> features{this, "features", "features.dictionary", "Network whose features are compared"};
    fresco::Option<std::string> layers{
        this, "layers", "", "Layers to compare, such as \"relu1_1, relu2_1\"; empty: the network's own choice for styles"};
    fresco::Option<std::vector<double>> layer_weights{this, "layer_weights", std::vector<double>{}, fresco::at_least(0),
                                                      "Factor of each layer, in the order of layers; empty: 1 each"};
    fresco::Option<bool> centre{
        this, "centre", true,
        "Compare mean and covariance, each relative to the target's squared norm; otherwise the plain Gram "
        "matrix, mean square over its elements"};
    fresco::Option<std::string> targets{this, "targets", "fine", fresco::one_of({"fine", "coarse", "both"}),
                                        "Which size of the style picture: fine (256 px) on pixels that pass the angle filter, "
                                        "coarse (up to 4 times as large) on all pixels, or both"};

    struct Target
    {
        fresco::Pixels pixels;
        gram::Moments moments;
    };
    struct LayerTargets
    {
        std::string layer;
        double factor;
        std::vector<Target> targets;
    };

  public:
    fresco::LossNeeds needs() const override
    {
        fresco::LossNeeds needs;
        needs.features.push_back({.network = &*features, .names = names_, .whole = false, .camera = false});
        if (names_.empty())
            needs.features.back().names = fresco::split_layer_names(*layers);
        return needs;
    }

    void prepare(const fresco::PrepareContext& context) override
    {
        const at::NoGradGuard no_gradient;
        names_ = chosen_layers();
        targets_.clear();
        for (std::size_t i = 0; i < names_.size(); ++i)
            targets_.push_back({names_[i], layer_weights->empty() ? 1.0 : layer_weights->at(i), {}});
        if (*targets != "fine")
            add_targets(context.style.coarse, fresco::Pixels::all);
        if (*targets != "coarse")
            add_targets(context.style.fine, fresco::Pixels::fine);
    }

    std::vector<fresco::LossTerm> evaluate(fresco::Part& part) override
    {
        std::vector<fresco::LossTerm> terms;
        for (const auto& layer : targets_)
        {
            torch::Tensor value;
            for (const auto& target : layer.targets)
            {
                const auto selected = part.selected(*features, layer.layer, target.pixels);
                if (selected.size(1) == 0)
                    continue;
                const auto term = distance(gram::moments(selected), target.moments);
                value = value.defined() ? value + term : term;
            }
            if (value.defined())
                terms.push_back({layer.layer, value * layer.factor});
        }
        return terms;
    }

  private:
    std::vector<std::string> chosen_layers() const
    {
        auto names = fresco::split_layer_names(*layers);
        if (names.empty())
            for (const auto& layer : features->layers())
                if (layer.style)
                    names.push_back(layer.name);
        for (const auto& name : names)
            features->layer(name);
        if (names.empty())
            throw fresco::Error("loss.gram: the network of `features` has no layer meant for styles; name some in `layers`");
        if (!layer_weights->empty() && layer_weights->size() != names.size())
            throw fresco::Error("loss.gram: `layer_weights` has " + std::to_string(layer_weights->size()) + " entries for " +
                                std::to_string(names.size()) + " layers; give one for each, or none");
        return names;
    }

    void add_targets(const torch::Tensor& picture, fresco::Pixels pixels)
    {
        const auto encoded = features->encode(picture, names_);
        for (std::size_t i = 0; i < names_.size(); ++i)
        {
            if (encoded[i].numel() == 0)
                throw fresco::Error("loss.gram: the style picture (" + std::to_string(picture.size(2)) + " x " +
                                    std::to_string(picture.size(1)) + ") is too small for layer " + names_[i] +
                                    ": use a larger picture or fewer layers");
            targets_[i].targets.push_back({pixels, gram::moments(encoded[i].flatten(1))});
        }
    }

    torch::Tensor distance(const gram::Moments& moments, const gram::Moments& target) const
    {
        if (!*centre)
            return gram::mean_square_difference(moments.second, target.second);
        return gram::relative_square_difference(moments.mean, target.mean) +
               gram::relative_square_difference(gram::covariance(moments), gram::covariance(target));
    }

    std::vector<std::string> names_;
    std::vector<LayerTargets> targets_;
};

}  // namespace

FRESCO_COMPONENT("loss.gram", LossGram, fresco::Loss, "Style as the moments of features: Gram matrices, or mean and covariance")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
