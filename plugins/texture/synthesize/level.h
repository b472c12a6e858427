#pragma once

#include "nearby_uses.h"
#include "patches.h"
#include "search.h"
#include "style_picture.h"

#include <fresco/image.h>
#include <fresco/math.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

/// \file The surface painted at one size of texels: each round searches the picture for every patch, then lets the patches vote
/// on the color of each texel. The synthesis runs levels from coarse to fine; tests compare single levels with a plain twin.

namespace fresco::synthesize
{

/// A patch's window: a Gaussian (σ = 0.35 sides) that falls to 0 at the patch's border. The weight of a patch in the vote is that
/// of its window times that of its fit (Kwatra et al. 2005).
class Window
{
  public:
    explicit Window(int side);

    /// Weight of a point, `offset` texels from the patch's center: 0 … 1.
    float operator()(Vec2f offset) const { return along(offset.x) * along(offset.y); }

  private:
    static constexpr float steps = 64;  ///< Per texel; linear between.

    float along(float offset) const
    {
        const float at = std::min(std::abs(offset) * steps, static_cast<float>(values_.size() - 2));
        const auto step = static_cast<std::size_t>(at);
        return values_[step] + (values_[step + 1] - values_[step]) * (at - static_cast<float>(step));
    }

    std::vector<float> values_;
};

/// The color of a point according to the patches over it.
struct Vote
{
    Vec3f mean;           ///< Weighted mean, not shifted yet.
    Vec3f heaviest;       ///< Color of the patch with the largest weight.
    std::uint32_t patch;  ///< The patch with the largest weight.
    Vec2f offset;         ///< The point on that patch, in texels from its center.
    float weight;         ///< Weight of that patch; negative where no patch lies.
    Vec3f shift;          ///< Weighted mean of the patches', L*a*b*; not in the colors yet.

    /// Mean of the colors in L*a*b*, after the shift.
    Vec3f shifted_mean() const { return mean + shift; }
};

/// `fits`: per patch, the weight of its fit. `offset_on(patch)`: the point on the patch, in texels from its center.
/// `color(place)`: color of a place in the picture.
template <class Offset, class Color>
Vote vote(std::span<const std::uint32_t> covers, std::span<const Match> matches, std::span<const float> fits,
          const Window& window, const Offset& offset_on, const Color& color)
{
    Vote result{};
    Vec3f sum;
    Vec3f shifts;
    float total = 0;
    result.weight = -1;
    for (const std::uint32_t patch : covers)
    {
        const Match& match = matches[patch];
        const Vec2f offset = offset_on(patch);
        const float weight = window(offset) * fits[patch];
        if (weight <= 0 && result.weight >= 0)
            continue;
        const Vec3f own = color(match.place(offset));
        sum += own * weight;
        shifts += match.shift * weight;
        total += weight;
        if (weight > result.weight)
        {
            result.weight = weight;
            result.heaviest = own;
            result.patch = patch;
            result.offset = offset;
        }
    }
    result.mean = total > 0 ? sum * (1 / total) : result.heaviest;
    result.shift = total > 0 ? shifts * (1 / total) : result.weight >= 0 ? matches[result.patch].shift : Vec3f{};
    return result;
}

/// The inputs of a synthesis, the same for all levels. Refers to them; they must outlive it.
struct Task
{
    const PaintedSurface& surface;
    const Upright& upright;
    const Raster8& picture;  ///< The style picture, RGB.
    /// The start's displayed RGB at a texcoord of a chart, averaged over about `footprint` in texcoords.
    std::function<Vec3f(std::uint32_t chart, Vec2f uv, double footprint)> start;
    std::span<const Vec3f> lines = {};  ///< Per face the direction of strokes, without a sign; empty: as in the picture.
    Raster8 opaque = {};                ///< Mask of the style picture, 0 = transparent; empty: all opaque.
    const texturing::TexelFaces* start_faces = nullptr;  ///< The start's texels, for a texture of its size; may be null.
};

/// Settings of one level.
struct LevelOptions
{
    int side = 11;              ///< Points along a patch.
    int stride = 4;             ///< Texels between patches.
    double faithfulness = 0.5;  ///< g: share of the start in the wanted colors; the rest is the painting so far.
    double unrest = 0;          ///< L*a*b*: noise added to the coarsest level's start, so that plain surfaces get strokes too.
    double least_missing = 0;   ///< L*a*b*: a level over another counts where this much is missing(), fully from twice that on.
    SearchOptions search = {};
};

/// A surface painted at one size of texels. A level over another one has finer strokes, and only where that one does not show
/// what is in the start. There it begins with the start, around with the other's painting, so that its strokes continue that.
class Level
{
  public:
    /// `spacing_m`: a texel's side. `scale`: pixels of the level's picture per pixel of the style picture. `under`: finished; it
    /// is settled by this, and must outlive this level.
    Level(const Task& task, double spacing_m, double scale, const LevelOptions& options, const Progress& progress,
          Level* under = nullptr);
    Level(const Level&) = delete;  // Its parts refer to each other.

    const SurfaceGrid& grid() const { return grid_; }
    const Patches& patches() const { return patches_; }
    const StylePicture& picture() const { return picture_; }
    const std::vector<Match>& matches() const { return matches_; }
    const std::vector<float>& crowding() const { return crowding_; }
    const std::vector<Vec3f>& colors() const { return colors_; }
    const Level* under() const { return under_; }
    /// Per texel, how much this level counts over the one under it, 0 … 1; empty without one.
    const std::vector<float>& share() const { return share_; }

    /// Begins with the start, or with the result of a coarser level (not of one over another): with its colors, and with its
    /// places in the picture as the last round's matches, so that the first search knows what is seen nearby.
    void begin(const Level* coarser, const Progress& progress);
    /// Continues an earlier run after a round. Throws Error unless sizes fit this surface and picture and all values are finite,
    /// Canceled.
    void resume(std::vector<Match> matches, std::vector<float> crowding, const Progress& progress);
    /// One round: a search, then a vote, unless nothing needs colors() afterward: not `is_voted`. \pre A round that refines
    /// follows another.
    void paint_round(Round round, const Progress& progress, bool is_voted = true);
    /// Frees what only rounds, missing() and levels that begin with this one need: it can still vote.
    void settle();

    /// Per texel, how much of what the start shows over about a stroke is not in the painting, in L*a*b*: the start's standard
    /// deviation, times 1 - the slope of the regression of the painting on it (0 … 1), times the start's share of the sum of its
    /// variance and that of the painting's rest: what would not stand out from the strokes is not missed.
    std::vector<float> missing(const Progress& progress) const;

    /// A vote, with the level of the patch with the largest weight.
    struct LevelVote : Vote
    {
        const Level* level;
    };

    /// The vote on a point of a chart, of this level and those under it. `color(level, place)`: color of a place in a level's
    /// picture.
    template <class Color>
    LevelVote vote_at(std::uint32_t chart, Vec2f uv, Vec3f position, const Color& color) const
    {
        const std::uint32_t texel = texel_near(chart, uv);
        const float share = share_.empty() ? 1 : share_[texel];
        if (share <= 0)
            return under_->vote_at(chart, uv, position, color);
        const Vec3f center = grid_.texels()[texel].position;
        const Vec3f away = (position - center) * static_cast<float>(1 / grid_.spacing_m());
        const LevelVote own{vote(
                                patches_.covers(texel), matches_, fits_, window_,
                                [&](std::uint32_t patch)
                                {
                                    const TangentFrame& frame = patches_[patch].frame;
                                    return patches_.offset(patch, center) + Vec2f{dot(away, frame.right), dot(away, frame.down)};
                                },
                                [&](Vec2f at) { return color(*this, at); }),
                            this};
        if (share >= 1)
            return own;
        const LevelVote other = under_->vote_at(chart, uv, position, color);
        LevelVote result = own.weight * share > other.weight * (1 - share) ? own : other;
        result.mean = own.mean * share + other.mean * (1 - share);
        result.shift = own.shift * share + other.shift * (1 - share);
        return result;
    }

  private:
    void set_matches(std::vector<Match> matches);
    void vote_colors(const Progress& progress);
    std::uint32_t texel_near(std::uint32_t chart, Vec2f uv) const;

    /// Texels where a finer level counts.
    struct Unshown
    {
        std::vector<float> share;         ///< Per texel of this level.
        std::vector<std::uint8_t> faces;  ///< 1: within about a patch of a texel with a share.
    };
    /// Settles the level.
    Unshown unshown(double least_missing, const Progress& progress);
    std::vector<float> share_over(const Unshown& unshown, const Progress& progress) const;

    Level(const Task& task, double spacing_m, double scale, const LevelOptions& options, const Progress& progress,
          const Level* under, const Unshown& unshown);

    const Task& task_;
    LevelOptions options_;
    const Level* under_;
    SurfaceGrid grid_;
    std::vector<float> share_;
    Patches patches_;
    Window window_;
    StylePicture picture_;
    std::vector<Vec3f> start_;   ///< Per texel, L*a*b*.
    std::vector<Vec3f> colors_;  ///< Per texel, L*a*b*, as painted.
    NearbyUses uses_;
    std::vector<Match> matches_;
    std::vector<float> fits_;      ///< Per patch.
    std::vector<float> crowding_;  ///< Per key of the picture.
};

}  // namespace fresco::synthesize
