#pragma once

#include "exposure.h"
#include "gather.h"

#include <fresco/camera.h>
#include <fresco/image.h>
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
    KeptSample(float weight, const std::array<float, 3>& rgb)
        : bits_(std::uint64_t{std::bit_cast<std::uint32_t>(weight) >> 16U} << 48U)
    {
        for (std::size_t c = 0; c < 3; ++c)
            bits_ |= static_cast<std::uint64_t>(std::clamp(rgb[c] * steps + 0.5F, 0.0F, 65535.0F)) << (16 * c);
    }

    bool empty() const { return weight_bits() == 0; }
    float weight() const { return std::bit_cast<float>(static_cast<std::uint32_t>(weight_bits()) << 16U); }
    std::array<float, 3> rgb() const
    {
        const auto channel = [&](unsigned c) { return static_cast<float>(bits_ >> (16 * c) & 0xffffU) * (1 / steps); };
        return {channel(0), channel(1), channel(2)};
    }
    bool heavier_than(const KeptSample& other) const { return weight_bits() > other.weight_bits(); }

  private:
    static constexpr float steps = 32767;

    std::uint64_t weight_bits() const { return bits_ >> 48U; }

    std::uint64_t bits_ = 0;  ///< The upper half of a float, then blue, green and red.
};

struct ExposedSample
{
    std::uint32_t texel = 0;
    KeptSample kept;
};

/// Multiplies the samples' weights and colors by the factors (colors clamped to 2) and leaves those without weight out. With
/// gains, saturated samples stay white, since factors would tint them, and count 0.3 times, since their brightness is unknown.
std::vector<ExposedSample> exposed(std::span<const TexelSample> samples, float weight_factor, const Gains* gains);

/// Samples this near to the others are never rejected.
constexpr float least_distance = 0.15F;

struct Blend
{
    std::array<float, 3> rgb{};  ///< [0,1]
    int used = 0;                ///< Number of samples.
    int rejected = 0;            ///< Number of these left out as outliers.
};

/// The color of one texel from its samples, heaviest first (empty places last; at least one is not).
///
/// If no place is empty, the last one's weight is subtracted from all weights, so that a view's share is zero where it enters or
/// leaves the best ones and the texture has no steps (Buehler et al., "Unstructured lumigraph rendering", SIGGRAPH 2001, section
/// 4). The rest is averaged by Tukey's biweight around the geometric median: a sample's share falls with
/// its distance, and is zero beyond three times the weighted median distance or `nearest`, whichever is more. Up to half
/// of the weight may be wrong. Distances are root mean squares over the channels.
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

    /// All places of a texel, heaviest first, empty ones last, in `out`, which has most_places. Empty if no view shows it.
    std::span<const KeptSample> of(std::size_t texel, std::span<KeptSample, most_places> out) const;

  private:
    /// Arrays of one length. They are made in pages, so that making more copies none.
    class Arrays
    {
      public:
        explicit Arrays(std::size_t length) : length_(length) {}
        /// Returns its number, above 0. Its places are empty.
        std::uint32_t make();
        std::span<KeptSample> operator[](std::uint32_t number) const
        {
            return {&pages_[(number - 1) / per_page][(number - 1) % per_page * length_], length_};
        }

      private:
        static constexpr std::size_t per_page = 1024;
        std::size_t length_;
        std::uint32_t count_ = 0;
        std::vector<std::unique_ptr<KeptSample[]>> pages_;
    };

    std::size_t first_;
    Arrays heavier_;
    Arrays lighter_;
    std::vector<std::uint32_t> heavier_of_;  ///< Per texel; 0: none.
    std::vector<std::uint32_t> lighter_of_;  ///< Per array of heavier ones; 0: none.
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
