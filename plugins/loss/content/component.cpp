#include <fresco/error.h>
#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>
#include <torch/version.h>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <optional>

namespace
{

class LossContent final : public fresco::Loss, public fresco::JointLoss
{
    fresco::Slot<fresco::FeatureNetwork> features{this, "features", "features.vgg19", "Network whose features are compared"};
    fresco::Option<std::string> layers{this, "layers", "",
                                       "Layers to compare, such as \"relu4_2\"; empty: the network's own choice for content"};

  public:
    fresco::LossNeeds needs() const override
    {
        fresco::LossNeeds needs;
        needs.features.push_back({.network = &*features, .names = names_, .whole = false, .camera = true});
        if (names_.empty())
            needs.features.back().names = fresco::split_layer_names(*layers);
        return needs;
    }

    void prepare(const fresco::PrepareContext&) override
    {
        names_ = fresco::split_layer_names(*layers);
        if (names_.empty())
            for (const auto& layer : features->layers())
                if (layer.content)
                    names_.push_back(layer.name);
        for (const auto& name : names_)
            features->layer(name);
        if (names_.empty())
            throw fresco::Error("loss.content: the network of `features` has no default layer for content; name one in `layers`");
    }

    std::vector<fresco::LossTerm> evaluate(fresco::Part& part) override
    {
        std::vector<fresco::LossTerm> terms;
        for (const auto& name : names_)
        {
            const auto seen = part.selected(*features, name, fresco::Pixels::all);
            if (seen.size(1) == 0)
                continue;
            const auto camera = part.camera_selected(*features, name, fresco::Pixels::all);
            const auto difference = seen - camera;
            const auto mean = fresco::ordered_mean(difference * difference);
            terms.push_back({name, mean, &*features});
        }
        return terms;
    }

    std::optional<std::vector<fresco::LossTerm>> evaluate_together(fresco::Levels& levels) override
    {
        std::vector<fresco::LossTerm> terms;
        for (const auto& name : names_)
        {
            const auto seen = levels.selected(*features, name);
            if (seen.size(1) == 0)
                continue;
            const auto keep = [&](const char* what, const std::function<torch::Tensor()>& make)
            { return levels.kept(fmt::format("{} {} {}", fmt::ptr(this), what, name), make); };
            // The roots of the factors, so that one sum of squares is the sum over the levels.
            const auto weights = keep("weights", [&] { return column_weights(levels, name); });
            const auto target = keep("target", [&] { return levels.camera_selected(*features, name) * weights; });
            const auto squares = at::mse_loss(seen * weights, target, at::Reduction::None);
            terms.push_back({name, fresco::ordered_sum(squares), &*features});
        }
        return terms;
    }

  private:
    /// For each column the root of what its squares count, 1 x N.
    torch::Tensor column_weights(fresco::Levels& levels, const std::string& name) const
    {
        const auto camera = levels.camera_selected(*features, name);
        std::vector<torch::Tensor> parts;
        for (const auto& level : levels.columns(*features, name))
        {
            const auto count = static_cast<double>(std::max<std::int64_t>(1, camera.size(0) * level.count));
            parts.push_back(at::full({1, level.count}, std::sqrt(level.share / count), camera.options()));
        }
        return at::cat(parts, 1);
    }

    std::vector<std::string> names_;
};

}  // namespace

FRESCO_COMPONENT("loss.content", LossContent, fresco::Loss, "Mean squared difference from the camera picture's features")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
