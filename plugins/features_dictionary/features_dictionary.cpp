#include "dictionary.h"

#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/features.h>

#include <torch/version.h>

#include <algorithm>

namespace
{

class FeaturesDictionary final : public fresco::FeatureNetwork
{
    fresco::Option<int> patches{this, "patches", 20'000, fresco::range(1'000, 1'000'000),
                                "Patches per layer to learn from, half of them from a noisy copy of the picture"};
    fresco::Option<double> noise{
        this, "noise", 0.25, fresco::range(0, 10),
        "Standard deviation of the copy's noise, in [0,1] colours; teaches the features what speckle is"};
    fresco::Option<double> epsilon{this, "epsilon", 0.1, fresco::range(1e-6, 1e6), "Floor of the whitening, in mean eigenvalues"};
    fresco::Option<int> iterations{this, "iterations", 12, fresco::range(1, 1'000), "Rounds of k-means"};

  public:
    void prepare(const fresco::PrepareContext& context) override
    {
        dictionary_ = dictionary::Dictionary::learn(
            context.style.fine,
            {.patches = *patches, .noise = *noise, .epsilon = *epsilon, .iterations = *iterations, .seed = context.seed},
            *context.progress);
        dictionary_.move_to(context.style.fine.device());
    }

    std::vector<fresco::FeatureLayer> layers() const override { return dictionary::Dictionary::layers(); }

    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const override
    {
        const auto known = layers();
        std::vector<std::size_t> indices;
        for (const auto& name : names)
        {
            const auto stride = layer(name).stride;
            indices.push_back(static_cast<std::size_t>(
                std::find_if(known.begin(), known.end(), [&](const auto& l) { return l.stride == stride; }) - known.begin()));
        }
        const auto deepest = indices.empty() ? 0 : *std::max_element(indices.begin(), indices.end()) + 1;
        const auto maps = dictionary_.encode(picture, deepest);
        std::vector<torch::Tensor> result;
        for (const auto index : indices)
            result.push_back(maps.at(index));
        return result;
    }

  private:
    dictionary::Dictionary dictionary_;
};

}  // namespace

FRESCO_COMPONENT("features.dictionary", FeaturesDictionary, fresco::FeatureNetwork,
                 "Features learned from the style picture itself; nothing to download")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
