#pragma once

#include <fresco/torch/loss.h>

#include <torch/types.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// \file For the tests of losses and feature networks: a part without an optimizer.

namespace fresco::testing
{

/// A network whose features are known by hand. Layer "a", meant for styles: the picture itself; layer "b", meant for
/// contents: its 2x2 averages.
class ColorNetwork final : public FeatureNetwork
{
  public:
    void prepare(const PrepareContext& context) override;
    std::vector<FeatureLayer> layers() const override;
    std::vector<torch::Tensor> encode(const torch::Tensor& picture, const std::vector<std::string>& layers) const override;
};

/// The loss of `type` in a built plugin, configured by `options` (JSON) with a ColorNetwork as its `features`.
std::unique_ptr<Loss> loss_on_colors(const std::filesystem::path& library, const std::string& type, const std::string& options);

/// One picture as a part. Whole networks are encoded at the first question. Fields may be set before use.
class PicturePart final : public Part
{
  public:
    /// `picture` and `camera`: 3 x H x W, RGB in [0,1], float32 or float64. All pixels are valid and pass the angle filter.
    PicturePart(const torch::Tensor& picture, const torch::Tensor& camera);
    /// `mask`, `fine`: H x W, bool; the picture is set to 0 where `mask` is false.
    PicturePart(const torch::Tensor& picture, const torch::Tensor& camera, torch::Tensor mask, torch::Tensor fine);

    int level_index = 0;
    std::int64_t step_index = 0;
    std::int64_t view_index = 0;
    std::int64_t repeat_index = 0;

    int level() const override { return level_index; }
    int height_px() const override { return static_cast<int>(picture_.size(1)); }
    std::int64_t step() const override { return step_index; }
    std::int64_t view() const override { return view_index; }
    std::int64_t repeat() const override { return repeat_index; }
    std::uint64_t seed() const override { return static_cast<std::uint64_t>(step_index); }

    torch::Tensor image() override { return picture_; }
    torch::Tensor camera() override { return camera_; }
    torch::Tensor mask(Pixels pixels) override;

    torch::Tensor features(const FeatureNetwork& network, const std::string& layer) override;
    torch::Tensor camera_features(const FeatureNetwork& network, const std::string& layer) override;
    torch::Tensor feature_mask(const FeatureNetwork& network, const std::string& layer, Pixels pixels) override;
    torch::Tensor selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels) override;
    torch::Tensor camera_selected(const FeatureNetwork& network, const std::string& layer, Pixels pixels) override;
    std::int64_t fine_count(const FeatureNetwork& network, const std::string& layer) override;

  private:
    using Encoded = std::map<std::pair<const FeatureNetwork*, std::string>, torch::Tensor>;
    static const torch::Tensor& encoded(Encoded& known, const torch::Tensor& picture, const FeatureNetwork& network,
                                        const std::string& layer);

    torch::Tensor picture_;
    torch::Tensor camera_;
    torch::Tensor mask_;
    torch::Tensor fine_;
    Encoded features_;
    Encoded camera_features_;
};

}  // namespace fresco::testing
