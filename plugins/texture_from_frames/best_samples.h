#pragma once

#include "gather.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace fresco::from_frames
{

/// What a texel keeps of a view, in eight bytes.
class KeptSample
{
  public:
    KeptSample() = default;
    /// \param weight  above 0; kept to 1/256 of itself, rounded down
    /// \param rgb     each from 0 to 2, kept to 1/32767
    KeptSample(float weight, const std::array<float, 3>& rgb);

    bool empty() const { return weight_ == 0; }
    float weight() const;
    std::array<float, 3> rgb() const;
    bool heavier_than(const KeptSample& other) const { return weight_ > other.weight_; }

  private:
    std::uint16_t weight_ = 0;  ///< The upper half of a float.
    std::array<std::uint16_t, 3> rgb_{};
};

struct BlendRules
{
    bool reject_outliers;
};

struct Blend
{
    std::array<float, 3> rgb{};  ///< [0,1]
    int used = 0;                ///< Samples that took part, …
    int rejected = 0;            ///< … of them left out because they disagree.
};

/// The color of one texel from its samples, heaviest first (empty places last; at least one is not).
///
/// Where every place is taken, the last one's weight is taken off all weights, so that a view's share is zero where it enters
/// and leaves the best ones: there are no steps in the texture (Buehler et al., "Unstructured lumigraph rendering", SIGGRAPH
/// 2001, section 4). The rest is averaged; with `reject_outliers` as Tukey's biweight does it around the geometric median: a
/// sample's share falls with its distance, and is zero beyond three times the weighted median distance or 0.15, whichever is
/// more. Up to half of the weight may be wrong. Distances are root mean squares over the channels.
Blend blended(std::span<const KeptSample> samples, const BlendRules& rules);

/// The heaviest samples of every texel. Its memory does not grow with the views.
class BestSamples
{
  public:
    /// `places`: samples per texel, 2 to 64; the last serves as the threshold, see blended.
    BestSamples(std::size_t texels, std::size_t places);

    /// Takes samples of one view, each texel at most once; their weights and colors are multiplied by the factors (colors cut
    /// at 2). With a gain, saturated samples stay white, where factors would tint them, and count 0.3 times: how bright they
    /// were is not known. Of equally heavy samples the first stays. Different texels' samples may be added side by side.
    void add(std::span<const TexelSample> samples, float weight_factor, const std::optional<std::array<float, 3>>& gain);

    /// All places of a texel, heaviest first, empty ones last.
    std::span<const KeptSample> of(std::size_t texel) const { return {kept_.data() + texel * places_, places_}; }

  private:
    std::size_t places_;
    std::vector<KeptSample> kept_;
};

}  // namespace fresco::from_frames
