#pragma once

#include <fresco/image.h>

#include <cstdint>
#include <span>
#include <string>
#include <utility>

namespace fresco::optimize
{

/// What the texture's numbers mean: `display` = RGB in [0,1]; `network` = BGR in 0..255 minus (103.939,
/// 116.779, 123.68). Pictures are shown as displayed RGB, clamped to [0,1].
class ValueSpace
{
  public:
    /// `values`: "display" or "network". With `clamped` false pictures are shown beyond [0,1] too, and all gradients pass.
    explicit ValueSpace(const std::string& values, bool clamped = true) : network_(values == "network"), clamped_(clamped) {}

    /// The range of stored values whose every channel may be displayed; each layer's in the authors' code.
    std::pair<double, double> stored_range() const;

    /// `stored`, `displayed`: 3 planes of P values each; where `valid` (P) is 0 the displayed value is 0.
    void display(std::span<const float> stored, std::span<const std::uint8_t> valid, std::span<float> displayed) const;
    /// The derivative of the above: `gradient` (3 planes, d loss / d displayed) times `factor` (P) to d loss / d stored, in
    /// place. Inside the displayable range all of it passes; outside only where a step against the gradient leads back, so that
    /// no texel is stuck beyond the range.
    void back(std::span<const float> stored, std::span<const float> factor, std::span<float> gradient) const;
    /// Displayed RGB (3 channels) to stored values, in place.
    void store(RasterF& picture) const;

    bool is_network() const { return network_; }
    bool is_clamped() const { return clamped_; }
    /// Displayed channel c shows (stored + offset) * scale of the stored plane plane_of(c).
    float offset(std::size_t channel) const;
    float scale() const { return network_ ? 1.0F / 255 : 1.0F; }
    std::size_t plane_of(std::size_t channel) const { return network_ ? 2 - channel : channel; }

  private:
    float shown(float stored, std::size_t channel) const;

    bool network_;
    bool clamped_;
};

}  // namespace fresco::optimize
