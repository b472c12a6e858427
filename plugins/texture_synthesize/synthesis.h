#pragma once

#include "patches.h"
#include "search.h"
#include "style_picture.h"

#include <fresco/image.h>
#include <fresco/image_io.h>
#include <fresco/mesh.h>
#include <fresco/run_context.h>
#include <fresco/texture.h>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

/// \file Paints a surface from coarse to fine. A Level is the surface at one size of texels: each round searches the picture for
/// every patch, then lets the patches vote on the color of each texel. paint() makes the texture of the finest level. The stage
/// calls synthesize(), which runs all levels; tests compare single levels with a plain twin.

namespace fresco::synthesize
{

/// The weight of a patch in the vote: a Gaussian window (σ = 0.35 sides, falling to 0 at its border) times the quality of its fit
/// (Kwatra et al. 2005).
float vote_weight(Vec2f offset, float side, float distance);

/// The color of a point according to the patches over it.
struct Vote
{
    Vec3f mean;           ///< Weighted mean.
    Vec3f heaviest;       ///< Color of the patch with the largest weight.
    std::uint32_t patch;  ///< The patch with the largest weight.
    Vec2f offset;         ///< The point on that patch, in texels from its center.
};

/// `shift(patch)`: vector from the covered texel's center to the point, in texels of the patch's plane. `color(place)`: color of
/// a place in the picture.
template <class Shift, class Color>
Vote vote(std::span<const Cover> covers, std::span<const Match> matches, int side, const Shift& shift, const Color& color)
{
    Vote result{};
    Vec3f sum;
    float total = 0;
    float most = -1;
    for (const Cover& cover : covers)
    {
        const Match& match = matches[cover.patch];
        const Vec2f offset = cover.offset() + shift(cover.patch);
        const float weight = vote_weight(offset, static_cast<float>(side), match.distance);
        if (weight <= 0 && most >= 0)
            continue;
        const Vec3f own = color(match.place(offset));
        sum += own * weight;
        total += weight;
        if (weight > most)
        {
            most = weight;
            result.heaviest = own;
            result.patch = cover.patch;
            result.offset = offset;
        }
    }
    result.mean = total > 0 ? sum * (1 / total) : result.heaviest;
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
};

/// Settings of one level.
struct LevelOptions
{
    int side;             ///< Points along a patch.
    int stride;           ///< Texels between patches.
    double faithfulness;  ///< g: share of the start in the wanted colors; the rest is the painting so far.
    double unrest;        ///< L*a*b*: noise added to the coarsest level's start, so that plain surfaces get strokes too.
    SearchOptions search;
};

/// A surface painted at one size of texels.
class Level
{
  public:
    /// `spacing_m`: a texel's side. `scale`: pixels of the level's picture per pixel of the style picture.
    Level(const Task& task, double spacing_m, double scale, const LevelOptions& options, const Progress& progress);

    const SurfaceGrid& grid() const { return grid_; }
    const Patches& patches() const { return patches_; }
    const StylePicture& picture() const { return picture_; }
    const std::vector<Match>& matches() const { return matches_; }
    const std::vector<float>& crowding() const { return crowding_; }
    const std::vector<Vec3f>& colors() const { return colors_; }

    /// Begins with the start, or with the result of a coarser level.
    void begin(const Level* coarser, const Progress& progress);
    /// Continues an earlier run. Throws Error unless sizes fit this surface and picture and all values are finite.
    void resume(std::vector<Vec3f> colors, std::vector<Match> matches, std::vector<float> crowding);
    /// One round: a search, then a vote.
    void paint_round(const Progress& progress);

    /// The median angle (degrees) between the lines and the strokes as painted, by the structure tensor of L* over each patch.
    /// \pre There are lines.
    double direction_error_deg(const Progress& progress) const;

    /// The vote on a point of a chart near a texel. `color(place)`: color of a place in the level's picture.
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
    StylePicture picture_;
    std::vector<Vec3f> start_;   ///< Per texel, L*a*b*.
    std::vector<Vec3f> colors_;  ///< The same, as painted.
    std::vector<Match> matches_;
    std::vector<float> crowding_;  ///< Per key of the picture.
};

struct Painting
{
    Texture texture;
    SourceMap source;
};

/// Makes the texture of `size_px` texels a side from a finished level: the patches over each texel that a chart touches vote once
/// more, with colors of the style picture at the texture's own size (never enlarged). The texel mixes the color of the patch with
/// the largest weight (`heaviest_share`) with the mean of all. The same for any number of threads. Throws Canceled.
Painting paint(const Task& task, const Level& level, int size_px, Progress& progress);

/// The side of a texel on the surface in meters, by the area of the charts. The mesh must have texcoords. Throws Error if they or
/// the surface have no area.
double mean_texel_m(const Mesh& mesh, int size_px);

/// Of strokes: `wanted_m`, or where that is 0, by the size of what is painted: 3.5 cm for a surface 3 m long or longer, in
/// proportion for a smaller one, and at least two texels. Throws Error if the wanted ones are narrower than two texels, or wider
/// than the surface is long.
double stroke_width_m(const Mesh& mesh, double wanted_m, double texel_m);

struct SynthesisOptions
{
    int size_px;          ///< Texels per side of the texture.
    double stroke_m;      ///< Width of the picture's strokes (see stroke_width_px) on the surface.
    double painterly;     ///< 0 … 1
    double completeness;  ///< See SearchOptions.
    int patch_px;         ///< Points along a patch, odd.
    int levels_count;     ///< Each has half the resolution of the next.
    int rounds_count;     ///< Per level.
    std::uint32_t seed;
    double checkpoint_seconds;  ///< Maximum seconds of work that a killed run loses; 0: no checkpoints.
    double preview_seconds;     ///< Between previews.
};

/// Paints a surface from coarse to fine: strokes are 8 texels wide in the finest level and half as many in each coarser one; then
/// the texture. Levels finer than the texture are left out, so that a smaller texture is the same painting, stopped early.
/// Resumes from a checkpoint of an interrupted run, with the same result. `images`: writes previews; may be null. Throws
/// Canceled.
Painting synthesize(const Task& task, const SynthesisOptions& options, const ImageIo* images, RunContext& run);

}  // namespace fresco::synthesize
