#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/tensor.h>

#include <ATen/ATen.h>

namespace
{

/// Draws the mean color of the rendering to the style picture's: the sum over the channels of the squared difference of the
/// means.
class MyPlugin final : public fresco::Loss
{
    fresco::Option<double> strength{this, "strength", 1.0, fresco::range(0, 10),
                                    "How far the mean moves from the camera picture's (0) to the style's (1)"};

  public:
    /// The optimizer encodes only what losses ask for. This one reads pixels and no features.
    fresco::LossNeeds needs() const override
    {
        fresco::LossNeeds needs;
        needs.picture = true;
        return needs;
    }

    void prepare(const fresco::PrepareContext& context) override
    {
        style_mean_ = fresco::ordered_mean(context.style.fine.flatten(1), 1);
    }

    /// One level of one frame. Depth levels, the angle filter and the scaling of gradients are the optimizer's: a part holds the
    /// pixels that belong to it, and this looks at no others.
    std::vector<fresco::LossTerm> evaluate(fresco::Part& part) override
    {
        const auto inside = part.mask(fresco::Pixels::all).flatten().nonzero().flatten();
        if (inside.numel() == 0)
            return {};
        // In a fixed order: the same bytes for any number of threads.
        const auto seen = fresco::ordered_mean(part.image().flatten(1).index_select(1, inside), 1);
        const auto camera = fresco::ordered_mean(part.camera().flatten(1).index_select(1, inside), 1);
        const auto style = style_mean_.to(seen.device(), seen.scalar_type());
        const auto target = camera + *strength * (style - camera);
        return {{"", fresco::ordered_sum((seen - target).square())}};
    }

  private:
    torch::Tensor style_mean_;  ///< 3
};

}  // namespace

FRESCO_COMPONENT("my.plugin", MyPlugin, fresco::Loss, "The mean color of what is seen is the style's")
