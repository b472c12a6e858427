#pragma once

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

/// \file The style picture at the size of one level, with the patches (keys) that a search may find in it, their principal
/// components and the directions of its strokes. search() compares patches of the surface with it.

namespace fresco::synthesize
{

/// `v`, rotated by the rotation that takes the x axis to `turn` (unit length).
inline Vec2f turned(Vec2f v, Vec2f turn)
{
    return {v.x * turn.x - v.y * turn.y, v.x * turn.y + v.y * turn.x};
}

typedef float Color __attribute__((vector_size(16)));

/// The colors of a picture at any place, bilinear, pixel centers at whole numbers, clamped at its border. Four values a pixel, so
/// that one instruction weighs a color.
template <class T>
class ColorLookup
{
  public:
    ColorLookup() = default;
    explicit ColorLookup(const Raster<T>& picture) : width_(picture.width), height_(picture.height)
    {
        // The last pixel of each row has a next one, too.
        for (int y = 0; y < height_; ++y)
            for (int x = 0; x <= width_; ++x)
            {
                const T* const rgb = &picture.at(std::min(x, width_ - 1), y);
                values_.insert(values_.end(), {rgb[0], rgb[1], rgb[2], T{}});
            }
    }

    Vec3f operator()(Vec2f at) const
    {
        const float x = std::clamp(at.x, 0.0F, static_cast<float>(width_ - 1));
        const float y = std::clamp(at.y, 0.0F, static_cast<float>(height_ - 1));
        const int column = static_cast<int>(x);
        const int row = static_cast<int>(y);
        const Color across = Color{} + (x - static_cast<float>(column));
        const Color above = between(pixel(column, row), across);
        const Color below = between(pixel(column, std::min(row + 1, height_ - 1)), across);
        const Color result = above + (below - above) * (y - static_cast<float>(row));
        return {result[0], result[1], result[2]};
    }

  private:
    /// The color between a pixel and the next one in its row.
    static Color between(const T* left, Color across)
    {
        Color a, b;
        if constexpr (std::is_same_v<T, float>)
        {
            std::memcpy(&a, left, sizeof a);
            std::memcpy(&b, left + 4, sizeof b);
        }
        else
        {
            // Both pixels' bytes become 16, then 32 bits wide: a compiler would convert them one by one.
            using Bytes = std::uint8_t __attribute__((vector_size(16)));
            using Words = std::uint16_t __attribute__((vector_size(16)));
            using Ints = std::int32_t __attribute__((vector_size(16)));
            Bytes bytes{};
            std::memcpy(&bytes, left, 8);
            const auto words =
                (Words)__builtin_shufflevector(bytes, Bytes{}, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
            a = __builtin_convertvector((Ints)__builtin_shufflevector(words, Words{}, 0, 8, 1, 9, 2, 10, 3, 11), Color);
            b = __builtin_convertvector((Ints)__builtin_shufflevector(words, Words{}, 4, 12, 5, 13, 6, 14, 7, 15), Color);
        }
        return a + (b - a) * across;
    }
    const T* pixel(int column, int row) const
    {
        return &values_[4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width_ + 1) +
                             static_cast<std::size_t>(column))];
    }

    int width_ = 0;
    int height_ = 0;
    std::vector<T> values_;
};

/// Searches compare colors in whole steps of a sixteenth L*a*b*: a few vector instructions compare a patch.
inline constexpr float steps_per_lab = 16;
inline std::int16_t in_steps(float lab)
{
    const float steps = std::clamp(lab * steps_per_lab, -2047.0F, 2047.0F);
    return static_cast<std::int16_t>(steps + std::copysign(0.5F, steps));
}

/// The mean of `count` values, three per color.
Vec3f mean_color(const float* values, std::size_t count);

/// A copy may be shifted in color as a whole, as a painter mixes a stroke a little lighter: more places of the picture then fit,
/// so that plain surfaces do not repeat one, and what the start shows stays legible (bias compensation: Darabi et al. 2012). The
/// shift makes up for this share of what the mean of a copy lacks, but for no more than the limit.
inline constexpr float shift_share = 0.75F;
inline constexpr float most_shift = 14;  ///< L*a*b*

/// The shift for a copy whose mean falls short by `gap`, L*a*b*.
inline Vec3f shift_for(Vec3f gap)
{
    const Vec3f shift = gap * shift_share;
    const float size = length(shift);
    return size > most_shift ? shift * (most_shift / size) : shift;
}

/// Cost of a gap: the square of what the shift leaves of it, and a price for the shift. Within the limit it is
/// (1 - shift_share) |gap|², as the principal components count it.
inline float squared_gap(Vec3f gap)
{
    const Vec3f shift = shift_for(gap);
    const Vec3f rest = gap - shift;
    return dot(rest, rest) + (1 / shift_share - 1) * dot(shift, shift);
}

/// The style picture at one size, and the patches of it that are looked for.
/// Positions are in pixels of this size, with pixel centers at whole numbers. Immutable, so thread-safe.
class StylePicture
{
  public:
    static constexpr std::size_t most_keys = 8000;
    static constexpr std::size_t most_features = 24;

    /// `scale`: this picture's pixels along a pixel of `rgb`. `side`: of a patch, odd. Keys are patches on a regular grid, every
    /// second pixel or as many as most_keys allows. `stroke_px`: width of strokes in this picture; turns every key so that
    /// strokes run along its x axis; 0: keys are not turned. `opaque`: of the size of `rgb`; pixels of less than 255 are in no
    /// patch; empty: all are opaque. Throws Error for a picture smaller than a patch, without an opaque one, or without
    /// contrast.
    StylePicture(const Raster8& rgb, double scale, int side, const Progress& progress, double stroke_px = 0,
                 const Raster8& opaque = {});

    double scale() const { return scale_; }
    int side() const { return side_; }
    const RasterF& lab() const { return lab_; }
    std::size_t values_per_patch() const { return 3 * static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_); }

    std::size_t key_count() const { return opaque_keys_.empty() ? grid_count() : opaque_keys_.size(); }
    Vec2f key(std::size_t number) const;
    /// The key nearest to a position.
    std::size_t key_near(Vec2f at) const;
    /// Half the distance between keys, in whole pixels.
    int key_reach() const;

    bool is_directed() const { return !directions_.empty(); }
    /// The direction of the strokes at a place, without a sign: unit length, x >= 0. \pre is_directed()
    Vec2f direction(Vec2f at) const;
    /// How far strokes at a place deviate from `turn`: from 0 to 1, if they are clearly across. \pre is_directed()
    float misalignment(Vec2f at, Vec2f turn) const;

    /// Projects `rows` patches (L*a*b*, side² x 3 values each, one after another) to the principal components of the keys. The
    /// mean color of a patch counts less (see squared_gap).
    std::size_t feature_count() const { return features_; }
    void project(const float* patches, std::size_t rows, float* features) const;
    /// K x feature_count().
    const std::vector<float>& key_features() const { return key_features_; }

    /// Frees what only searches need.
    void forget_means() { means_ = RasterF(); }

    /// The nearest position at which a whole patch lies in the picture.
    Vec2f inside(Vec2f at) const;
    /// Whether a whole patch lies on opaque pixels there, however it is turned. \pre inside(at) == at
    bool has_patch(Vec2f at) const;
    /// The number of opaque pixels in the rectangle from (x0, y0) to before (x1, y1).
    double opaque_count(int x0, int y0, int x1, int y1) const;
    /// L*a*b* at any place.
    Vec3f color(Vec2f at) const { return colors_(at); }
    /// The values of the patch around a whole pixel begin here, in steps; rows are lab().width * 3 apart.
    const std::int16_t* patch(int x, int y) const { return &steps_.at(x - side_ / 2, y - side_ / 2); }
    /// The mean of these values. \pre !is_directed(), and a whole patch fits there.
    Vec3f patch_mean(int x, int y) const
    {
        const float* mean = &means_.at(x, y);
        return {mean[0], mean[1], mean[2]};
    }
    /// The values of the patch around any place whose x axis runs along `turn`, bilinear: side² x 3.
    void turned_patch(Vec2f at, Vec2f turn, float* values) const;

  private:
    /// The structure tensor's entry at a place: see directions_.
    const float* twice_angle(Vec2f at) const
    {
        return &directions_.at(std::clamp(static_cast<int>(std::lround(at.x)), 0, directions_.width - 1),
                               std::clamp(static_cast<int>(std::lround(at.y)), 0, directions_.height - 1));
    }
    std::size_t grid_count() const { return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_); }
    Vec2f grid_place(std::size_t number) const;
    /// For each half pixel along an axis, the nearest of `count` columns or rows of the grid.
    std::vector<std::uint32_t> nearest_along(int pixels, int count) const;
    void find_opaque_keys(const Raster8& opaque);
    void find_means(const Progress& progress);
    void find_directions(double stroke_px);
    void make_basis(const Progress& progress);

    double scale_;
    int side_;
    RasterF lab_;
    Raster<std::int16_t> steps_;         ///< lab_ in steps.
    ColorLookup<float> colors_;          ///< The colors of lab_.
    RasterF means_;                      ///< Means of the patch around each pixel; empty with directions.
    int border_;                         ///< From a patch's center to its farthest point along x or y, however it is turned.
    Raster<std::uint32_t> opaque_sums_;  ///< Counts of opaque pixels above and to the left; empty: all are opaque.
    /// Places of the grid where an opaque patch lies, and for each place the nearest of these keys; empty: all places are keys.
    std::vector<std::uint32_t> opaque_keys_;
    std::vector<std::uint32_t> nearest_key_;
    RasterF directions_;  ///< Per pixel the structure tensor's cos and sin of twice the angle along strokes, times coherence.
    int columns_ = 0;
    int rows_ = 0;
    std::vector<std::uint32_t> column_near_;
    std::vector<std::uint32_t> row_near_;
    double key_step_ = 1;
    std::size_t features_ = 0;
    std::vector<float> mean_;   ///< values_per_patch()
    std::vector<float> basis_;  ///< values_per_patch() x feature_count()
    std::vector<float> key_features_;
};

}  // namespace fresco::synthesize
