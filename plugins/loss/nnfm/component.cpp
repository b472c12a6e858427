#include "nearest.h"

#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/random.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>

#include <ATen/core/grad_mode.h>
#include <torch/version.h>

namespace
{

class LossNnfm final : public fresco::Loss
{
    fresco::StyleOptions style{this};
    /// Style features searched per layer: more hardly find nearer ones, and the search takes time in proportion.
    static constexpr int max_style_samples = 4096;
    /// Features of a view compared per layer, for the same reason.
    static constexpr int max_samples = 16'384;

    /// One size of the style picture: unit features of a layer, M x C, and the pixels that are compared with them.
    struct Target
    {
        fresco::Pixels pixels;
        torch::Tensor rows;
    };

  public:
    fresco::LossNeeds needs() const override { return style.needs(compared_); }

    void prepare(const fresco::PrepareContext& context) override
    {
        const at::NoGradGuard no_gradient;
        compared_ = style.compared(type);
        targets_.assign(compared_.size(), {});
        fresco::Random random(context.seed);
        for (const auto& role : style.roles(context.style))
        {
            const auto features = fresco::style_features(*style.features, role.picture, compared_, type);
            for (std::size_t i = 0; i < features.size(); ++i)
            {
                const auto samples = nnfm::sampled_columns(features[i], max_style_samples, random.bits());
                targets_[i].push_back({role.pixels, nnfm::unit_rows(samples.t().contiguous())});
            }
        }
    }

    std::vector<fresco::LossTerm> evaluate(fresco::Part& part) override
    {
        std::vector<fresco::LossTerm> terms;
        fresco::Random random(part.seed());
        for (std::size_t i = 0; i < compared_.size(); ++i)
        {
            torch::Tensor sum;
            for (const auto& target : targets_[i])
            {
                const auto seed = random.bits();
                const auto features = part.selected(*style.features, compared_[i].name, target.pixels);
                if (features.size(1) == 0)
                    continue;
                const auto value = nnfm::distance(nnfm::sampled_columns(features, max_samples, seed), target.rows);
                sum = sum.defined() ? sum + value : value;
            }
            if (sum.defined())
                terms.push_back({compared_[i].name, sum * compared_[i].factor, &*style.features});
        }
        return terms;
    }

  private:
    static constexpr std::string_view type = "loss.nnfm";

    std::vector<fresco::StyleLayer> compared_;
    std::vector<std::vector<Target>> targets_;  ///< Per layer.
};

}  // namespace

FRESCO_COMPONENT("loss.nnfm", LossNnfm, fresco::Loss,
                 "Pulls each feature toward its nearest style feature, by the angle between them")
FRESCO_LIBRARY("libtorch", TORCH_VERSION)
