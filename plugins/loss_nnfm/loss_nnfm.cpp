#include "nearest.h"

#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/style_layers.h>

#include <torch/version.h>

namespace
{

class LossNnfm final : public fresco::StyleFeatureLoss
{
    fresco::Option<int> max_style_samples{this, "max_style_samples", 4096, fresco::range(16, 1'000'000),
                                          "Most features of the style per layer that are searched"};
    fresco::Option<int> max_samples{this, "max_samples", 16'384, fresco::range(16, 10'000'000),
                                    "Most features of a view per layer that look for theirs"};

  public:
    LossNnfm() : StyleFeatureLoss("loss.nnfm") {}

  private:
    torch::Tensor target_of(const torch::Tensor& features, std::uint64_t seed) const override
    {
        return nnfm::unit_rows(fresco::sampled_columns(features, *max_style_samples, seed).t().contiguous());
    }

    torch::Tensor distance(const torch::Tensor& features, const torch::Tensor& target, std::uint64_t seed) const override
    {
        return nnfm::distance(fresco::sampled_columns(features, *max_samples, seed), target);
    }
};

}  // namespace

FRESCO_COMPONENT("loss.nnfm", LossNnfm, fresco::Loss,
                 "Draws every feature to its nearest feature of the style picture, by the angle between them")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
