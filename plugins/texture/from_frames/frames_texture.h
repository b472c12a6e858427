#pragma once

#include "exposure.h"
#include "gather.h"

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/numerics/wide_vectors.h>
#include <fresco/parallel.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// \file Blends the camera pictures into the stage's texture: solves their exposures, keeps the heaviest samples of each texel
/// and averages them. Views are streamed, so memory hardly grows with their number.

namespace fresco::from_frames
{

/// A sample as a texel keeps it, in eight bytes.
class KeptSample
{
  public:
    KeptSample() = default;
    /// \param weight  above 0; kept to 1/256 of itself, rounded down
    /// \param rgb     each from 0 to 2, kept to 1/32767
    KeptSample(float weight, Four rgb) : bits_(std::uint64_t{std::bit_cast<std::uint32_t>(weight) >> 16U} << 48U)
    {
        rgb = rgb * steps + 0.5F;
        rgb = rgb > 0 ? rgb : Four{};
        rgb = rgb < 65535 ? rgb : Four{} + 65535;
        for (std::size_t c = 0; c < 3; ++c)
            bits_ |= static_cast<std::uint64_t>(static_cast<std::int32_t>(rgb[c])) << (16 * c);
    }

    /// Greater for heavier ones; 0: empty.
    std::uint16_t order() const { return static_cast<std::uint16_t>(bits_ >> 48U); }
    float weight() const { return std::bit_cast<float>(std::uint32_t{order()} << 16U); }
    std::array<float, 3> rgb() const
    {
        const auto channel = [&](unsigned c) { return static_cast<float>(bits_ >> (16 * c) & 0xffffU) * (1 / steps); };
        return {channel(0), channel(1), channel(2)};
    }
    bool heavier_than(const KeptSample& other) const { return order() > other.order(); }

  private:
    static constexpr float steps = 32767;

    std::uint64_t bits_ = 0;  ///< The upper half of a float, then blue, green and red.
};

struct ExposedSample
{
    std::uint32_t texel = 0;
    KeptSample kept;
};

/// A sample with its weight and color multiplied by the factors (colors clamped to 2). Saturated samples stay white, since
/// factors would tint them, and count 0.3 times, since their brightness is unknown.
KeptSample exposed(float weight, Four rgb, Four gain);

/// Samples this near to the others are never rejected.
constexpr float least_distance = 0.15F;

struct Blend
{
    std::array<float, 3> rgb{};  ///< [0,1]
    int used = 0;                ///< Number of samples.
    int rejected = 0;            ///< Number of these left out as outliers.
};

/// The samples of some texels, each heaviest first (at least one), an empty one behind them if there are less than places; a span
/// that is empty stands for no texel.
using TexelsSamples = std::array<std::span<const KeptSample>, numerics::wide_vectors::lanes>;

/// The colors of the texels.
///
/// If no place is empty, the last one's weight is subtracted from all weights, so that a view's share is zero where it enters or
/// leaves the best ones and the texture has no steps (Buehler et al., "Unstructured lumigraph rendering", SIGGRAPH 2001, section
/// 4). The rest is averaged by Tukey's biweight around the geometric median: a sample's share falls with
/// its distance, and is zero beyond three times the weighted median distance or `nearest`, whichever is more. Up to half
/// of the weight may be wrong. Distances are root mean squares over the channels.
std::array<Blend, numerics::wide_vectors::lanes> blended(const TexelsSamples& texels, float nearest);
Blend blended(std::span<const KeptSample> samples, float nearest = least_distance);

/// The heaviest samples of a range of texels. Its memory does not grow with the views: a texel takes some once a view shows it,
/// and twice as much once half of its places are full.
class BestSamples
{
  public:
    static constexpr std::size_t most_places = 64;

    /// `places`: samples per texel, 2 to most_places; the last one is the threshold, see blended. `first`: the first texel's
    /// number.
    BestSamples(std::size_t texels, std::size_t places, std::size_t first = 0);

    /// Keeps the first of equally heavy samples.
    void add(std::span<const ExposedSample> samples);

    /// Whether a sample of this weight would be kept.
    bool has_room(std::size_t texel, float weight) const
    {
        return KeptSample(weight, Four{}).order() > texels_[texel - first_].lightest;
    }

    /// The samples of a texel, as blended wants them. Empty if no view shows it.
    std::span<const KeptSample> of(std::size_t texel) const;

  private:
    /// Arrays of one length. They are made in pages, so that making more copies none.
    class Arrays
    {
      public:
        explicit Arrays(std::size_t length) : length_(length) {}
        /// Returns the number of one whose places are empty.
        std::uint32_t make();
        void give_back(std::uint32_t number);
        std::span<KeptSample> operator[](std::uint32_t number) const
        {
            return {&pages_[number / per_page][number % per_page * length_], length_};
        }

      private:
        static constexpr std::size_t per_page = 1024;
        std::size_t length_;
        std::uint32_t count_ = 0;
        std::vector<std::uint32_t> free_;
        std::vector<std::unique_ptr<KeptSample[]>> pages_;
    };

    struct Texel
    {
        std::uint32_t array = 0;     ///< One of half_'s if it has at most half of the samples.
        std::uint16_t count = 0;     ///< Samples.
        std::uint16_t lightest = 0;  ///< Order of the last sample once every place is taken, else 0.
    };

    std::size_t first_;
    std::size_t places_;
    Arrays half_;  ///< With a place that stays empty at the end.
    Arrays all_;
    std::vector<Texel> texels_;
};

/// One view, as read.
struct View
{
    UvMap map;
    Camera camera;     ///< The color camera at full size.
    Raster8 picture;   ///< RGB, the camera's whole view at any size.
    RasterF measured;  ///< Measured depth in meters, of the map's size, 0 = none; empty: no depth picture, or not used.
    std::string sequence;
};

/// Reads view i, with its measured depth only if asked: a depth picture is decoded once. Called from several threads, twice for
/// each view.
using ViewReader = std::function<View(std::size_t i, bool with_depth)>;

struct TextureRules
{
    int size_px;
    int views_count;  ///< Per texel, 1 to 63.
};

struct FramesTexture
{
    RasterF picture;                   ///< S x S x 3, RGB in [0,1]; unseen texels continue the seen ones smoothly.
    Raster8 seen;                      ///< S x S: 1 = at least one view shows it.
    std::vector<Gains> gains;          ///< Per view.
    std::vector<double> sharpness;     ///< Per view: the factor of its weights.
    double error = 0;                  ///< Local log-color error, see BlendQuality …
    double error_without_gains = 0;    ///< … and what it would be.
    std::size_t blended_samples = 0;   ///< Over all texels.
    std::size_t rejected_samples = 0;  ///< Samples among these rejected as outliers.
    std::size_t pixels = 0;            ///< Valid pixels of the uv maps.
    std::size_t edge_pixels = 0;       ///< Pixels among these beside a depth step.
    std::size_t occluded_pixels = 0;   ///< Pixels among these rejected because of their measured depth.
};

/// Makes the texture of `count` views. Reads them twice, as many at a time as there are threads; memory grows with their number
/// only by 200 kB a view and a bit for each pixel of its map. The same bytes for any number of threads. Throws Error if no
/// view shows a texel, Canceled, and the exceptions of `read`.
FramesTexture frames_texture(std::size_t count, const ViewReader& read, const TextureRules& rules, Progress& progress);

/// The factor of each view's weights: its sharpness over the median of the views of its sequence from four before to four after
/// it, squared, within [0.1, 4]: it favors the sharper of two pictures of a place, but leaves a blurred one its share where it is
/// nearest. Only pictures of one surface from about one place are compared, since sharpness
/// depends on the subject. `sequences`: per view.
std::vector<double> sharpness_factors(const std::vector<double>& sharpness, const std::vector<std::string>& sequences);

}  // namespace fresco::from_frames
