#pragma once

#include <fresco/camera.h>
#include <fresco/image.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <vector>

/// \file The texels that one view shows, with their colors and weights: which pixels of its uv map belong together (PixelLinks),
/// the weight of each pixel, and the camera picture at any scale. frames_texture() gathers every view twice: at low resolution
/// for the exposures, then at full size for the texture.

namespace fresco::from_frames
{

/// A color and one number more.
typedef float Four __attribute__((vector_size(16)));

/// Looks a raster of four channels up at (u, v) in [0,1], rightward and downward; bilinear, clamped at the borders.
template <class T>
Four four_between(const Raster<T>& raster, float u, float v)
{
    const float x = std::clamp(u * static_cast<float>(raster.width) - 0.5F, 0.0F, static_cast<float>(raster.width - 1));
    const float y = std::clamp(v * static_cast<float>(raster.height) - 0.5F, 0.0F, static_cast<float>(raster.height - 1));
    const auto column = static_cast<int>(x);
    const auto row = static_cast<int>(y);
    const float right = x - static_cast<float>(column);
    const float down = y - static_cast<float>(row);
    const T* const first = raster.values.data() + raster.index(column, row);
    const std::ptrdiff_t next = column + 1 < raster.width ? 4 : 0;
    const std::ptrdiff_t below = row + 1 < raster.height ? std::ptrdiff_t{4} * raster.width : 0;
    const auto four_at = [&](std::ptrdiff_t offset)
    {
        typedef std::int32_t Bits __attribute__((vector_size(16)));
        std::array<T, 4> values;
        std::memcpy(&values, first + offset, sizeof values);
        if constexpr (sizeof(T) == 1)  // Compilers convert bytes one by one.
            return __builtin_convertvector((Bits{} + std::bit_cast<std::int32_t>(values)) >> Bits{0, 8, 16, 24} & 255, Four);
        else
            return std::bit_cast<Four>(values);
    };
    const Four a = four_at(0), b = four_at(next), c = four_at(below), d = four_at(below + next);
    const Four upper = a + (b - a) * right;
    const Four lower = c + (d - c) * right;
    return upper + (lower - upper) * down;
}

/// The place where one view shows a texel.
struct DrawnSample
{
    std::uint32_t texel = 0;  ///< As TexelSample has it.
    float weight = 0;         ///< Above 0.
    std::array<float, 2> at{};
    float covered = 0;  ///< Share of the picture that the texel covers.
};

/// A camera picture at every size down to less than two pixels, each the area average of the one before, in bytes: four times as
/// many pixels fit into a processor's cache as of floats. Immutable, so thread-safe.
class PicturePyramid
{
  public:
    /// `rgb`: 3 channels, not empty.
    explicit PicturePyramid(const Raster8& rgb);

    /// RGB in [0,1] at a place in the picture, in [0,1], rightward and downward, averaged over this share of the picture:
    /// bilinear in two levels (clamped at the borders), linear between them.
    Four at(const std::array<float, 2>& place, float covered) const
    {
        const float pixels = covered * static_cast<float>(levels_.front().width * levels_.front().height);
        const float lod = pixels > 1 ? std::min(std::log2(pixels) / 2, static_cast<float>(levels_.size() - 1)) : 0;
        const auto level = static_cast<std::size_t>(lod);
        Four color = four_between(levels_[level], place[0], place[1]);
        if (const float share = lod - static_cast<float>(level); share > 0)
            color += (four_between(levels_[level + 1], place[0], place[1]) - color) * share;
        return color * (1.0F / 255);
    }

  private:
    std::vector<Raster8> levels_;  ///< Four channels.
};

/// Tells which neighboring pixels of a uv map show neighboring points of one surface, and of one chart of the atlas.
class PixelLinks
{
  public:
    enum Link : std::uint8_t
    {
        surface_right = 1,  ///< No depth step between this pixel and the next one in its row.
        surface_down = 2,   ///< No depth step between this pixel and the next one in its column.
        texels_right = 4,   ///< Also close in the texture, so that the texels between may be interpolated.
        texels_down = 8
    };

    /// `camera`: the color camera at any size.
    ///
    /// At a depth step, 1 / depth jumps by more than 2 % + 1 cm from the linear continuation on either side; since 1 / depth is
    /// linear over a plane in any direction, oblique walls and their corners have no steps. Two pixels are far apart in the
    /// texture if their texcoords differ by more than five times their distance in the world times the scale of the charts, which
    /// is about the same for all: the view's lower quartile of texture per meter.
    PixelLinks(const UvMap& map, const Camera& camera);

    bool has(int x, int y, Link link) const { return (links_.at(x, y) & link) != 0; }

    double texture_per_m() const { return texture_per_m_; }

    /// H x W: 1 = valid, and beside a depth step or an invalid pixel.
    Raster8 at_steps() const;

  private:
    void link_surfaces(const UvMap& map);
    void link_texels(const UvMap& map, const Camera& camera);

    Raster8 links_;
    Raster8 valid_;
    double texture_per_m_ = 1;
};

/// Per pixel of a map: whether its measured depth differs from the mesh's. Empty: no pixel's does.
using RejectedPixels = std::vector<bool>;

/// \param measured  measured depth at each pixel of the map, meters, 0 = none; empty: no depth picture
RejectedPixels rejected_pixels(const UvMap& map, const RasterF& measured);

/// The weight of each pixel of a view.
struct ViewWeights
{
    /// H x W in [0,1]: 0 at the picture's border, beside depth steps, and where another surface occluded the mesh; rises to 1
    /// away from them, so that views begin and end softly.
    RasterF trust;
    /// H x W, above 0 to 1: the pixel's weight among views. cos α, times picture pixels per texel over a quarter (f² cos α / z²
    /// over the texture's density; at most 1), times trust. Without trust, a thousandth of it is left for texels that no other
    /// view shows. 0: rejected, or invalid.
    RasterF weight;
    std::size_t edge_pixels = 0;  ///< Without trust because of a depth step.
};

/// \param camera   the color camera at full size
/// \param size_px  texels a side of the texture
ViewWeights view_weights(const UvMap& map, const PixelLinks& links, const Camera& camera, const RejectedPixels& rejected,
                         int size_px);

/// Distance in pixels from each pixel to the nearest marked one, along steps to the eight neighbors (1 or √2; at most 8 % too
/// long); a large number where none is marked. After Borgefors, "Distance transformations in digital images" (1986).
RasterF distance_to(const Raster8& marked);

/// The color and weight of one texel in one view.
struct TexelSample
{
    std::uint32_t texel = 0;  ///< row * size + column; row 0 is at the top (v = 1).
    float weight = 0;         ///< Above 0.
    std::array<float, 3> rgb{};
    std::array<float, 2> at{};  ///< Place in the picture, in [0,1], rightward and downward.
};

/// Gets the samples of a view block by block: of the next texture rows, each texel at most once.
using SampleUser = std::function<void(std::size_t block, std::span<const DrawnSample> samples)>;

/// The texture that samples are gathered for.
struct GatherTarget
{
    int size_px = 0;            ///< Texels a side.
    int rows_per_block = 0;     ///< As SampleUser gets them.
    bool between_only = false;  ///< Leave out texels that lie beside pixels rather than between them.
};

/// Finds the place in the camera's picture of each texel that a view sees. Each square of four neighboring pixel centers that
/// show one surface and one chart (or three of them) is drawn into the texture as two triangles (or one), and the position in the
/// picture is interpolated for every texel center inside them. Textures finer than the map therefore have no holes, the picture's
/// resolution counts instead of the map's, and texels that cover many pixels get their mean.
///
/// At the rim of charts and pictures, where a pixel has no such squares around it, the texels of its bilinear footprint get its
/// color at a hundredth of its weight: it counts only if no other view shows the texel, as in atlases of tiny charts.
///
/// A texel that is drawn more than once keeps its heaviest sample, the first of equals.
/// \param weight  H x W, of each pixel of the map; 0: not used, nor are the texels between it and others
void gather(const UvMap& map, const PixelLinks& links, const RasterF& weight, const GatherTarget& target, const SampleUser& use);

}  // namespace fresco::from_frames
