#pragma once

#include <fresco/image.h>
#include <fresco/math.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// \file Looking a texture up, at the size at which a picture shows it.

namespace fresco::rendering
{

/// How a picture is looked up where a sample skips texels.
enum class TextureFilter
{
    trilinear,    ///< Between smaller copies of it.
    anisotropic,  ///< In up to eight places along the direction in which more texels are skipped, in copies that suit the other
                  ///< one.
    bilinear      ///< Always in the full one.
};

/// An RGB picture at every size down to 1 x 1, each the area average of the one before. A texel is one number with ten bits per
/// channel: those of the full picture are exact, the others at most 1/8 of 255 off.
class MipMaps
{
  public:
    /// Bilinear: the full size only. Throws Error unless the picture has 3 channels.
    MipMaps(const Raster8& picture, TextureFilter filter);

    int width() const { return levels_.front().width; }
    int height() const { return levels_.front().height; }

    /// The color (0..255 per channel) at uv, origin lower left: bilinear with texel centers at +0.5, clamped at the borders, and
    /// linear between the two levels around `lod` (0 = full size, 1 = half, …).
    Vec3d sample(Vec2d uv, double lod) const;

  private:
    friend class Lookups;

    struct Level
    {
        std::int32_t width;
        std::int32_t height;
        std::int32_t first;  ///< Index of its first texel.
        double scale_x;      ///< Its size over that of the full picture.
        double scale_y;
    };

    void add_level(const RasterF& colors);
    Vec3d sample_level(Vec2d uv, const Level& level) const;

    std::vector<Level> levels_;
    std::vector<std::uint32_t> texels_;
};

/// Many lookups made together, by vectors: what MipMaps::sample finds, in single precision.
class Lookups
{
  public:
    /// The maps must outlive this.
    explicit Lookups(const MipMaps& maps) : maps_(maps) {}

    /// Forgets what was added, and makes room for `most` lookups.
    void start(std::size_t most);
    /// Adds one at (u, v), in texels of the full size from the picture's lower left corner, times `weight`. One lookup becomes
    /// one or two of the `count()` places whose colors are summed up.
    void add(double u, double v, double lod, float weight)
    {
        if (lod > 0)
            add_smaller(u, v, lod, weight);
        else
            add_place(u - 0.5, maps_.height() - 0.5 - v, weight, maps_.levels_.front());
    }
    std::size_t count() const { return count_; }
    /// Finds the colors of all places.
    void look_up();
    /// `count()` numbers of a channel (0..2), each a position's share of its lookup.
    std::span<const float> colors(std::size_t channel) const { return std::span(colors_[channel]).first(count_); }

  private:
    void add_place(double x, double y, float weight, const MipMaps::Level& level)
    {
        x_[count_] = static_cast<float>(x);
        y_[count_] = static_cast<float>(y);
        weights_[count_] = weight;
        firsts_[count_] = level.first;
        widths_[count_] = level.width;
        heights_[count_] = level.height;
        ++count_;
    }
    void add_smaller(double u, double v, double lod, float weight);

    const MipMaps& maps_;
    std::size_t count_ = 0;
    std::vector<float> x_, y_;  ///< Texels of the level, 0 at a center.
    std::vector<float> weights_;
    std::vector<std::int32_t> firsts_, widths_, heights_;  ///< The levels' own.
    std::array<std::vector<float>, 3> colors_;
};

}  // namespace fresco::rendering
