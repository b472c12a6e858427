#pragma once

#include <fresco/torch/loss.h>

#include <map>
#include <string>
#include <vector>

namespace bench
{

/// Features of a picture, encoded once with all layers in demand when the first is asked for.
class Encoded
{
  public:
    torch::Tensor layer(const fresco::FeatureNetwork& network, const std::vector<std::string>& wanted, const std::string& name,
                        const torch::Tensor& picture);
    void forget() { maps_.clear(); }

  private:
    std::map<const fresco::FeatureNetwork*, std::map<std::string, torch::Tensor>> maps_;
};

/// The layers that losses want of each network.
using Wanted = std::map<const fresco::FeatureNetwork*, std::vector<std::string>>;
Wanted wanted_layers(const std::vector<std::shared_ptr<fresco::Loss>>& losses);

/// A picture of valid pixels as losses see it. The camera's features are kept in `camera_features`, for as long as the caller
/// wants. References its arguments.
class ViewPart final : public fresco::Part
{
  public:
    ViewPart(torch::Tensor image, const torch::Tensor& camera, Encoded& camera_features, const Wanted& wanted, std::int64_t step);
    ~ViewPart() override;

    int level() const override { return 0; }
    int height_px() const override { return static_cast<int>(image_.size(1)); }
    std::int64_t step() const override { return step_; }
    std::int64_t view() const override { return 0; }
    std::int64_t repeat() const override { return step_; }
    std::uint64_t seed() const override { return static_cast<std::uint64_t>(step_); }

    torch::Tensor image() override { return image_; }
    torch::Tensor camera() override { return camera_; }
    torch::Tensor mask(fresco::Pixels pixels) override;
    torch::Tensor features(const fresco::FeatureNetwork& network, const std::string& layer) override;
    torch::Tensor camera_features(const fresco::FeatureNetwork& network, const std::string& layer) override;
    torch::Tensor feature_mask(const fresco::FeatureNetwork& network, const std::string& layer, fresco::Pixels pixels) override;
    torch::Tensor selected(const fresco::FeatureNetwork& network, const std::string& layer, fresco::Pixels pixels) override;
    torch::Tensor camera_selected(const fresco::FeatureNetwork& network, const std::string& layer,
                                  fresco::Pixels pixels) override;
    fresco::FineColumns fine_among_selected(const fresco::FeatureNetwork& network, const std::string& layer) override;

  private:
    torch::Tensor image_;
    const torch::Tensor& camera_;
    Encoded& kept_;
    const Wanted& wanted_;
    Encoded features_;
    std::int64_t step_;
};

}  // namespace bench
