#include <fresco/option.h>
#include <fresco/plugin.h>
#include <fresco/stage.h>
#include <fresco/torch/features.h>

#include <ATen/ATen.h>

namespace
{

/// Two layers without weights. "edges": differences to the pixels on the right and below, of each channel. "shapes": the means of
/// their sizes over squares of 4 x 4.
class MyPlugin final : public fresco::FeatureNetwork
{
    fresco::Option<double> contrast{this, "contrast", 4.0, fresco::range(0.1, 100), "Factor of all features"};

  public:
    /// Learns or loads something once a run; unused here.
    void prepare(const fresco::PrepareContext&) override {}

    std::vector<fresco::FeatureLayer> layers() const override
    {
        return {{"edges", 6, 1, 1, true, false}, {"shapes", 6, 4, 1, true, true}};
    }

    /// Must be differentiable in the picture. Features of a cell depend only on the pixels of the cell and of `margin_px` around
    /// it: the optimizer encodes crops.
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& names) const override
    {
        const auto padded = at::replication_pad2d(picture.unsqueeze(0), {0, 1, 0, 1}).squeeze(0);
        const auto right = padded.slice(1, 0, -1).diff(1, 2);
        const auto down = padded.slice(2, 0, -1).diff(1, 1);
        const auto edges = at::cat({right, down}) * *contrast;
        std::vector<torch::Tensor> result;
        for (const auto& name : names)
            // layer() knows the names, and refuses others.
            result.push_back(layer(name).stride == 1 ? edges : at::avg_pool2d(edges.abs().unsqueeze(0), {4, 4}).squeeze(0));
        return result;
    }
};

}  // namespace

FRESCO_COMPONENT("my.plugin", MyPlugin, fresco::FeatureNetwork, "Differences of neighboring pixels, at two scales")
