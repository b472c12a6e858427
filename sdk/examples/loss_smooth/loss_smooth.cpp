#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/loss.h>
#include <fresco/torch/tensor.h>

#include <ATen/ops/abs.h>

namespace
{

using torch::indexing::None;
using torch::indexing::Slice;

/// Mean absolute difference of neighboring pixels: total variation (Rudin, Osher, Fatemi 1992, the anisotropic form).
class SmoothLoss final : public fresco::Loss
{
    fresco::LossNeeds needs() const override
    {
        fresco::LossNeeds needs;
        needs.picture = true;
        return needs;
    }

    void prepare(const fresco::PrepareContext&) override {}

    std::vector<fresco::LossTerm> evaluate(fresco::Part& part) override
    {
        const torch::Tensor image = part.image();
        // A difference counts where both of its pixels belong to the part.
        const torch::Tensor mask = part.mask(fresco::Pixels::all).to(image.scalar_type());
        const torch::Tensor right =
            (image.index({Slice(), Slice(), Slice(1, None)}) - image.index({Slice(), Slice(), Slice(0, -1)})).abs() *
            mask.index({Slice(), Slice(1, None)}) * mask.index({Slice(), Slice(0, -1)});
        const torch::Tensor down = (image.index({Slice(), Slice(1, None)}) - image.index({Slice(), Slice(0, -1)})).abs() *
                                   mask.index({Slice(1, None)}) * mask.index({Slice(0, -1)});
        return {{"", fresco::ordered_mean(right) + fresco::ordered_mean(down)}};
    }
};

}  // namespace

FRESCO_COMPONENT("example.smooth", SmoothLoss, fresco::Loss, "Total variation: the mean difference of neighboring pixels")
