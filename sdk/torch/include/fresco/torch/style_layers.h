#pragma once

#include <fresco/torch/loss.h>

#include <torch/types.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// \file What losses that compare features with the style picture do alike. `loss` is the loss's type, named in errors.

namespace fresco
{

/// A layer that is compared, and the factor of its term.
struct StyleLayer
{
    std::string name;
    double factor = 1;
};
std::vector<std::string> names_of(const std::vector<StyleLayer>& layers);

/// One size of the style picture and the pixels of a part that are compared with it (METHOD section 4).
struct StyleRole
{
    Pixels pixels;
    torch::Tensor picture;
};

/// Options that such losses share; a member of the loss.
struct StyleOptions
{
    explicit StyleOptions(Configurable* owner);

    Slot<FeatureNetwork> features;
    Option<std::string> layers;
    Option<std::vector<double>> layer_weights;
    Option<std::string> targets;

    /// The layers named, or the network's own for styles where none are, with their factors; the network is prepared. Throws
    /// Error for unknown layers, a wrong number of factors, a network without layers for styles.
    std::vector<StyleLayer> compared(std::string_view loss) const;
    /// Selected features of `compared`; of the layers named, where it is empty.
    LossNeeds needs(const std::vector<StyleLayer>& compared) const;
    /// The coarse picture on all pixels, the fine one on those that pass the angle filter, as `targets` says.
    std::vector<StyleRole> roles(const StylePictures& style) const;
};

/// The features of `picture` in each of the layers, C x N with N >= 1; no gradient. Throws Error where the picture is too small.
std::vector<torch::Tensor> style_features(const FeatureNetwork& network, const torch::Tensor& picture,
                                          const std::vector<StyleLayer>& layers, std::string_view loss);

/// At most `most` of the columns of `features` (C x N), differentiable: one from each of `most` equal runs of columns, drawn by
/// `seed`, in their order. All of them where N <= most; `most` >= 1.
torch::Tensor sampled_columns(const torch::Tensor& features, std::int64_t most, std::uint64_t seed);

/// A loss that compares, layer by layer and size by size, the features of a part with what it keeps of the style's. A layer
/// without features in the part gives no term.
class StyleFeatureLoss : public Loss
{
  public:
    ~StyleFeatureLoss() override;
    LossNeeds needs() const override;
    void prepare(const PrepareContext& context) override;
    std::vector<LossTerm> evaluate(Part& part) override;

  protected:
    explicit StyleFeatureLoss(std::string_view loss) : loss_(loss) {}

    /// What is kept of the style's `features` (C x N).
    virtual torch::Tensor target_of(const torch::Tensor& features, std::uint64_t seed) const = 0;
    /// A scalar: how far `features` (C x N, N >= 1) are from `target`. `seed` depends on run, step, level, layer and size.
    virtual torch::Tensor distance(const torch::Tensor& features, const torch::Tensor& target, std::uint64_t seed) const = 0;

  private:
    struct Target
    {
        Pixels pixels;
        torch::Tensor value;
    };

    std::string loss_;
    StyleOptions options_{this};
    std::vector<StyleLayer> compared_;
    std::vector<std::vector<Target>> targets_;  ///< Per layer.
};

}  // namespace fresco
