#pragma once

#include "patches.h"
#include "picture_level.h"
#include "search.h"
#include "vote.h"

#include <fresco/image.h>

#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace fresco::synthesize
{

/// What the whole of a synthesis is about. Refers to all of it.
struct Task
{
    const PaintedSurface& surface;
    const Upright& upright;
    const Raster8& picture;  ///< The style picture, RGB.
    /// The start's displayed RGB at a texcoord of a chart, averaged over about `footprint` in texcoords.
    std::function<Vec3f(std::uint32_t chart, Vec2f uv, double footprint)> start;
    std::span<const Vec3f> lines = {};  ///< Per face which way strokes run, of either sign; empty: as they lie in the picture.
};

/// How one level is painted.
struct LevelOptions
{
    int side;             ///< Points along a patch.
    int stride;           ///< Texels from patch to patch.
    double faithfulness;  ///< g: how much of what is looked for is the start; the rest is what was painted before.
    double unrest;        ///< L*a*b*: noise that the coarsest level's start gets, so that plain surfaces get strokes too.
    SearchOptions search;
};

/// A surface painted at one size of texels.
class Level
{
  public:
    /// `spacing_m`: a texel's side. `scale`: pixels of the level's picture along one of the style picture's.
    Level(const Task& task, double spacing_m, double scale, const LevelOptions& options, const Progress& progress);

    const SurfaceGrid& grid() const { return grid_; }
    const Patches& patches() const { return patches_; }
    const PictureLevel& picture() const { return picture_; }
    const std::vector<Match>& matches() const { return matches_; }
    const std::vector<float>& crowding() const { return crowding_; }
    const std::vector<Vec3f>& colors() const { return colors_; }

    /// Begins with the start, or with what a coarser level found.
    void begin(const Level* coarser, const Progress& progress);
    /// Goes on from where an earlier run was. Throws Error unless all is of this surface and picture, and finite.
    void resume(std::vector<Vec3f> colors, std::vector<Match> matches, std::vector<float> crowding);
    /// One round: search, then votes.
    void paint_round(const Progress& progress);

    /// The median angle (degrees) between the lines and the strokes as painted, by the structure tensor of L* over each patch.
    /// \pre There are lines.
    double direction_error_deg(const Progress& progress) const;

    /// What the patches say about a point of a chart near a texel, each color by `color(place in the level's picture)`.
    template <class Color>
    Vote vote_at(std::uint32_t chart, Vec2f uv, Vec3f position, const Color& color) const
    {
        const std::uint32_t texel = texel_near(chart, uv);
        const Vec3f away = (position - grid_.texels()[texel].position) * static_cast<float>(1 / grid_.spacing_m());
        return vote(
            patches_.covers(texel), matches_, patches_.side(),
            [&](std::uint32_t patch)
            {
                const TangentFrame& frame = patches_[patch].frame;
                return Vec2f{dot(away, frame.right), dot(away, frame.down)};
            },
            color);
    }

  private:
    std::uint32_t texel_near(std::uint32_t chart, Vec2f uv) const;

    const Task& task_;
    LevelOptions options_;
    SurfaceGrid grid_;
    Patches patches_;
    PictureLevel picture_;
    std::vector<Vec3f> start_;   ///< Per texel, L*a*b*.
    std::vector<Vec3f> colors_;  ///< The same, as painted.
    std::vector<Match> matches_;
    std::vector<float> crowding_;  ///< Per key of the picture.
};

}  // namespace fresco::synthesize
