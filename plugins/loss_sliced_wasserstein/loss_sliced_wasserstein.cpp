#include "slices.h"

#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/random.h>
#include <fresco/stage.h>
#include <fresco/torch/style_layers.h>

#include <torch/version.h>

namespace
{

class LossSlicedWasserstein final : public fresco::StyleFeatureLoss
{
    fresco::Option<int> directions_count{this, "directions_count", 0, fresco::range(0, 4096),
                                         "Random directions per step and layer; 0: as many as the layer has channels"};
    fresco::Option<int> max_samples{this, "max_samples", 16'384, fresco::range(16, 10'000'000),
                                    "Most features of a layer that are compared, of the view and of the style each"};

  public:
    LossSlicedWasserstein() : StyleFeatureLoss("loss.sliced_wasserstein") {}

  private:
    torch::Tensor target_of(const torch::Tensor& features, std::uint64_t seed) const override
    {
        return fresco::sampled_columns(features, *max_samples, seed).contiguous();
    }

    torch::Tensor distance(const torch::Tensor& features, const torch::Tensor& target, std::uint64_t seed) const override
    {
        fresco::Random random(seed);
        const auto channels = features.size(0);
        const auto directions = sliced::random_directions(*directions_count > 0 ? *directions_count : channels, channels,
                                                          random.bits(), target.options());
        return sliced::distance(fresco::sampled_columns(features, *max_samples, random.bits()), target, directions);
    }
};

}  // namespace

FRESCO_COMPONENT("loss.sliced_wasserstein", LossSlicedWasserstein, fresco::Loss,
                 "Style as the whole distribution of features, compared along random directions")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
