#include "synthesis.h"

#include "checkpoint.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/geometry/topology.h>
#include <fresco/images/lab.h>
#include <fresco/images/stroke_width.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numeric>
#include <string>

namespace fresco::synthesize
{

namespace
{

constexpr float heaviest_share = 0.75F;  // Share of the luminance.

/// RGB in [0,1]: the mean's color, lightened or darkened toward the heaviest patch's luminance (Rec. 709, of displayed values).
Vec3f mixed(const Vote& vote)
{
    const float lighter = heaviest_share * dot(Vec3f{0.2126F, 0.7152F, 0.0722F}, vote.heaviest - vote.mean);
    const auto clamped = [lighter](float v) { return std::clamp(v + lighter, 0.0F, 1.0F); };
    return {clamped(vote.mean.x), clamped(vote.mean.y), clamped(vote.mean.z)};
}

/// The style picture as a level is painted with it on a texture: smaller where a texel is more than a pixel.
struct LookedUp
{
    LookedUp(const Raster8& style, const Level& of, double texel_m)
        : level(&of), pixels_per_texel(texel_m / of.grid().spacing_m() / of.picture().scale())
    {
        const double scale = std::min(1.0, 1 / pixels_per_texel);
        const Raster8 picture = resized(style, std::max(1, static_cast<int>(std::lround(style.width * scale))),
                                        std::max(1, static_cast<int>(std::lround(style.height * scale))));
        colors = ColorLookup<std::uint8_t>(picture);
        const RasterF& searched = of.picture().lab();
        from_searched = {static_cast<float>(picture.width) / static_cast<float>(searched.width),
                         static_cast<float>(picture.height) / static_cast<float>(searched.height)};
    }

    /// RGB in [0,1] at a place in the level's picture.
    Vec3f color(Vec2f at) const
    {
        const Vec2f here{(at.x + 0.5F) * from_searched.x - 0.5F, (at.y + 0.5F) * from_searched.y - 0.5F};
        return colors(here) * (1 / 255.0F);
    }

    const Level* level;
    double pixels_per_texel;  ///< Pixels of the style picture for each texel.
    ColorLookup<std::uint8_t> colors;
    Vec2f from_searched;
};

}  // namespace

Painting paint(const Task& task, const Level& level, const texturing::TexelFaces& faces, Progress& progress)
{
    const Mesh& mesh = task.surface.mesh;
    const int size_px = faces.size;
    double uv_per_m = 0;
    double weight = 0;
    for (std::uint32_t c = 0; c < task.surface.charts.count; ++c)
        if (level.grid().has_sheet(c))
        {
            const SurfaceGrid::Sheet& sheet = level.grid().sheet(c);
            const double cells = static_cast<double>(sheet.width) * sheet.height;
            uv_per_m += cells * task.surface.uv_per_m[c];
            weight += cells;
        }
    uv_per_m /= weight;
    const double texel_m = 1 / (uv_per_m * size_px);

    std::vector<LookedUp> pictures;
    for (const Level* l = &level; l != nullptr; l = l->under())
        pictures.emplace_back(task.picture, *l, texel_m);
    const auto of = [&](const Level& l) -> const LookedUp& { return *std::ranges::find(pictures, &l, &LookedUp::level); };
    const double pixels_per_texel = pictures.back().pixels_per_texel;

    Painting result;
    const std::string atlas = atlas_id(mesh);
    result.texture.atlas = atlas;
    result.texture.layers.emplace_back(size_px, size_px, 3);
    result.texture.seen = Raster8(size_px, size_px);
    result.source.atlas = atlas;
    result.source.picture_width = task.picture.width;
    result.source.picture_height = task.picture.height;
    result.source.pixels_per_texel = static_cast<float>(pixels_per_texel);
    result.source.clear(size_px);

    const auto paint_texel = [&](int x, int y)
    {
        const std::size_t texel = static_cast<std::size_t>(y) * static_cast<std::size_t>(size_px) + static_cast<std::size_t>(x);
        if (!faces.covered(texel))
            return;
        const std::uint32_t face = faces.face[texel];
        const std::uint32_t chart = task.surface.charts.of_face[face];
        if (!level.grid().has_sheet(chart))
            return;
        const Vec2f uv{(static_cast<float>(x) + 0.5F) / static_cast<float>(size_px),
                       1 - (static_cast<float>(y) + 0.5F) / static_cast<float>(size_px)};
        const Level::LevelVote vote = level.vote_at(chart, uv, texturing::texel_position(mesh, faces, texel),
                                                    [&](const Level& l, Vec2f at) { return of(l).color(at); });
        float* out = &result.texture.layers[0].at(x, y);
        const Vec3f copied = mixed(vote);
        const Vec3f color = rgb_from_lab(lab_from_rgb(copied) + vote.shift);
        out[0] = color.x;
        out[1] = color.y;
        out[2] = color.z;
        result.texture.seen.at(x, y) = 1;
        const TangentFrame& frame = vote.level->patches()[vote.patch].frame;
        const RasterF& searched = vote.level->picture().lab();
        const Vec3f right = texcoord_axes(mesh, face).first;
        const Match& match = vote.level->matches()[vote.patch];
        const Vec2f at = match.place(vote.offset);
        const Vec2f in_picture = turned({dot(right, frame.right), dot(right, frame.down)}, match.turn);
        result.source.set_place(x, y,
                                {{(at.x + 0.5F) * static_cast<float>(task.picture.width) / static_cast<float>(searched.width),
                                  (at.y + 0.5F) * static_cast<float>(task.picture.height) / static_cast<float>(searched.height)},
                                 std::atan2(in_picture.y, in_picture.x),
                                 static_cast<float>(of(*vote.level).pixels_per_texel / pixels_per_texel),
                                 color - copied});
    };
    // Previews are painted between rounds: the count stays that of the rounds.
    parallel_items(static_cast<std::size_t>(size_px), 1, progress,
                   [&](std::size_t y)
                   {
                       for (int x = 0; x < size_px; ++x)
                           paint_texel(x, static_cast<int>(y));
                   });
    return result;
}

namespace
{

constexpr double least_texels = 2;
constexpr const char* check_unit = "; if the mesh is not in meters, read it with scan.mesh, which has the option unit_m";

}  // namespace

double texel_width_m(const Mesh& mesh, int size_px)
{
    const double texel_m = texturing::mean_texel_m(mesh, size_px);
    if (texel_m == 0)
        throw Error("the charts of the mesh on port 'mesh' have no area: wire an atlas.* stage");
    return texel_m;
}

double stroke_width_m(const Mesh& mesh, double wanted_m, double texel_m)
{
    const double longest_m = texturing::longest_side_m(mesh);
    if (wanted_m == 0)
        return texturing::usual_stroke_m(mesh, texel_m);
    if (wanted_m < least_texels * texel_m)
        throw Error(fmt::format("strokes of {:.6g} cm are too narrow for texels of {:.3g} cm: they need at "
                                "least {:g} texels, so use a stroke_cm of {:.3g} or more, or a larger size_px{}",
                                wanted_m * 100, texel_m * 100, least_texels, least_texels * texel_m * 100, check_unit));
    if (wanted_m > longest_m)
        throw Error(fmt::format("strokes of {:.6g} cm are wider than the room, which is {:.3g} cm long: use "
                                "a smaller stroke_cm{}",
                                wanted_m * 100, longest_m * 100, check_unit));
    return wanted_m;
}

namespace
{

constexpr double stroke_texels = 8;         // In the finest level of the broad strokes …
constexpr double detail_stroke_texels = 6;  // … and of finer ones.
constexpr double finest_texel = 0.6;        // Levels with texels smaller than this share of the texture's are left out.
constexpr int short_stride = 3;             // Between the smaller patches of strokes of fewer texels.
constexpr int preview_px = 512;
constexpr double slow_preview = 4;  // Previews of more than 1 / 4 s come less often, so that they take a twentieth of the time.
constexpr int least_patch_px = 5;
constexpr int most_halvings = 2;        // Halvings of the strokes' size, where there is detail.
constexpr int later_rounds = 2;         // Every broad level but the coarsest takes a round that searches and one that refines.
constexpr double least_missing = 0.45;  // L*a*b*: for half a stroke's width, with full detail …
constexpr double missing_ratio = 3;     // … and for each further halving: small strokes are few.

class Synthesis
{
  public:
    Synthesis(const Task& task, const SynthesisOptions& options, const ImageIo* images, RunContext& run)
        : task_(task), options_(options), images_(images), run_(run), stroke_px_(stroke_width_px(task.picture, run)),
          texel_m_(texel_width_m(task.surface.mesh, options.size_px)), finest_(finest_level()), halvings_(halvings_count())
    {
    }

    Painting make()
    {
        std::unique_ptr<Level> level;
        int number = options_.levels_count - 1;
        const auto take_up = [&](Checkpoint& found)
        {
            auto next = new_level(found.level);
            next->resume(std::move(found.matches), std::move(found.crowding), run_);
            level = std::move(next);
            number = found.level;
        };
        if (const int done = resumed(finest_, take_up); done > 0)
            paint_rounds(*level, number--, done);
        for (; number >= finest_; --number)
        {
            if (level)
                level->settle();
            auto next = new_level(number);
            next->begin(level.get(), run_);
            level = std::move(next);
            paint_rounds(*level, number, 0);
        }
        report(*level);
        return with_detail(std::move(level));
    }

  private:
    using Clock = std::chrono::steady_clock;

    Painting with_detail(std::unique_ptr<Level> broad)
    {
        std::vector<std::unique_ptr<Level>> levels;
        levels.push_back(std::move(broad));
        Value::List shares;
        for (int halvings = 1; halvings <= halvings_; ++halvings)
        {
            auto next = detail_level(halvings, *levels.back());
            shares.emplace_back(share_of_surface(*next, *levels.front()));
            if (next->patches().count() == 0)
                break;
            const auto take_up = [&](Checkpoint& found)
            { next->resume(std::move(found.matches), std::move(found.crowding), run_); };
            const int done = resumed(-halvings, take_up);
            if (done == 0)
                next->begin(nullptr, run_);
            paint_rounds(*next, -halvings, done);
            levels.push_back(std::move(next));
        }
        run_.report("detail_shares", std::move(shares));
        const bool is_of_start = task_.start_faces != nullptr && task_.start_faces->size == options_.size_px;
        return paint(task_, *levels.back(), is_of_start ? *task_.start_faces : texel_faces(options_.size_px), run_);
    }

    static double share_of_surface(const Level& level, const Level& whole)
    {
        const double texels = std::accumulate(level.share().begin(), level.share().end(), 0.0);
        const double size = level.grid().spacing_m() / whole.grid().spacing_m();
        return texels * size * size / static_cast<double>(whole.grid().texels().size());
    }

    double spacing_m(int level) const { return options_.stroke_m / stroke_texels * std::exp2(level); }
    double scale(int level) const { return stroke_texels / stroke_px_ / std::exp2(level); }

    /// Texels along a stroke of the halved width: fewer if the texture does not show them; 0: it does not show those either.
    double detail_texels(int halvings) const
    {
        for (const double texels : {detail_stroke_texels, stroke_texels / 2})
            if (options_.stroke_m / std::exp2(halvings) / texels >= finest_texel * texel_m_)
                return texels;
        return 0;
    }

    int halvings_count() const
    {
        int count = 0;
        while (options_.detail > 0 && count < most_halvings && detail_texels(count + 1) > 0)
            ++count;
        return count;
    }

    std::unique_ptr<Level> detail_level(int halvings, Level& under) const
    {
        const double texels = detail_texels(halvings);
        // With fewer texels, patches are smaller: else they would show no more detail than those under them.
        const int sixths = texels == detail_stroke_texels ? 5 : 4;
        LevelOptions options{.side = std::max(least_patch_px, options_.patch_px * sixths / 6 / 2 * 2 + 1),
                             .least_missing = least_missing / options_.detail * std::pow(missing_ratio, halvings - 1),
                             .search = {.stroke_px = texels, .seed = options_.seed}};
        if (texels < detail_stroke_texels)
            options.stride = short_stride;
        // Narrow strokes show the room: repeating them costs less.
        options.search.repeat_cost /= 2;
        options.search.weave_cost /= 2;
        return std::make_unique<Level>(task_, options_.stroke_m / std::exp2(halvings) / texels, texels / stroke_px_, options,
                                       run_, &under);
    }

    int finest_level() const
    {
        int level = options_.levels_count - 1;
        while (level > 0 && spacing_m(level - 1) >= finest_texel * texel_m_)
            --level;
        return level;
    }

    LevelOptions level_options(int level) const
    {
        const double freedom = 2 * options_.painterly;
        return {.side = options_.patch_px,
                .faithfulness = 0.5 * std::pow(0.3, options_.painterly),
                .unrest = 10 * freedom,
                .search = {.stroke_px = stroke_texels / std::exp2(level),
                           .variety = 5 * freedom,
                           .lift = static_cast<float>(8 * freedom),
                           .seed = options_.seed}};
    }

    std::unique_ptr<Level> new_level(int number) const
    {
        return std::make_unique<Level>(task_, spacing_m(number), scale(number), level_options(number), run_);
    }

    /// Levels over others have negative numbers and a file each, so that the levels under them are kept.
    std::filesystem::path file_of(int level) const
    {
        return run_.checkpoint_folder() / (level < 0 ? fmt::format("detail_{}.bin", -level) : "round.bin");
    }

    /// Takes up the checkpoint of a level from `lowest` on; the rounds that were done, 0: begin. Warns of a checkpoint
    /// that cannot be used.
    template <class TakeUp>
    int resumed(int lowest, const TakeUp& take_up) const
    {
        try
        {
            auto found = read_checkpoint(file_of(lowest));
            if (!found)
                return 0;
            take_up(*found);
            run_.message(fmt::format("going on after round {} of an interrupted run", found->rounds));
            return found->rounds;
        }
        catch (const Error& error)
        {
            run_.warning(std::string("the checkpoint cannot be used: ") + error.what());
            return 0;
        }
    }

    /// Rounds before those of the `index`-th level that is painted.
    int rounds_before(int index) const
    {
        const int broad = std::min(index, options_.levels_count - finest_);
        return index == 0 ? 0 : options_.rounds_count + (broad - 1) * later_rounds + index - broad;
    }

    void paint_rounds(Level& level, int number, int done)
    {
        const int broad_levels = options_.levels_count - finest_;
        const int index = number < 0 ? broad_levels - 1 - number : options_.levels_count - 1 - number;
        const int count = rounds_before(index + 1) - rounds_before(index);
        for (int round = done; round < count; ++round)
        {
            run_.progress(rounds_before(index) + round, rounds_before(broad_levels + halvings_), "rounds");
            // A finer level of the same strokes begins with the matches, one of finer strokes compares the colors.
            const bool is_compared = number <= finest_ && index + 1 < broad_levels + halvings_;
            level.paint_round(index > 0 && round > 0 ? Round::refines : Round::searches, run_, round + 1 < count || is_compared);
            double sum = 0;
            for (const Match& match : level.matches())
                sum += static_cast<double>(match.distance);
            run_.metric("distance", sum / static_cast<double>(level.matches().size()));
            const auto now = Clock::now();
            const auto since = [now](Clock::time_point then) { return std::chrono::duration<double>(now - then).count(); };
            // A level that others go over is kept as it ends.
            const bool is_end = number == finest_ && round + 1 == count && halvings_ > 0;
            if (options_.checkpoint_seconds > 0 && since(is_end ? started_ : saved_) >= options_.checkpoint_seconds)
            {
                write_checkpoint(file_of(number), {number, round + 1, level.matches(), level.crowding()});
                saved_ = Clock::now();
            }
            if (images_ != nullptr && since(shown_) >= options_.preview_seconds * std::max(1.0, slow_preview * preview_took_))
            {
                show(level);
                shown_ = Clock::now();
                preview_took_ = std::chrono::duration<double>(shown_ - now).count();
            }
        }
    }

    texturing::TexelFaces texel_faces(int size_px) const
    {
        return texturing::find_texel_faces(task_.surface.mesh, task_.surface.charts, size_px, run_);
    }

    void show(const Level& level)
    {
        if (shown_faces_.size == 0)
            shown_faces_ = texel_faces(std::min(preview_px, options_.size_px));
        const Painting small = paint(task_, level, shown_faces_, run_);
        const Raster8 picture = texturing::to_bytes(small.texture.layers.front(), run_);
        write_file(run_.preview_folder() / "texture.png", images_->encode_png(picture));
    }

    void report(const Level& level) const
    {
        const double pixel_cm = 100 * options_.stroke_m / stroke_px_;
        const double longest_cm = 100 * texturing::longest_side_m(task_.surface.mesh);
        if (const double short_cm = pixel_cm * std::min(task_.picture.width, task_.picture.height); short_cm > longest_cm)
            run_.warning(
                fmt::format("with strokes of {:.2g} cm, the picture would be {:.0f} cm wide and the surface is {:.0f} cm long: "
                            "only parts of the picture's motifs are seen; a smaller stroke_cm shows more of them",
                            100 * options_.stroke_m, pixel_cm * task_.picture.width, longest_cm));
        run_.report("stroke_px", stroke_px_);
        run_.report("stroke_cm", 100 * options_.stroke_m);
        run_.report("picture_width_cm", pixel_cm * task_.picture.width);
        run_.report("picture_height_cm", pixel_cm * task_.picture.height);
        run_.report("texel_mm", 1000 * texel_m_);
        run_.report("searched_texel_mm", 1000 * spacing_m(finest_));
        run_.report("searched_texels", level.grid().texels().size());
        run_.report("patches", level.patches().count());
        run_.report("keys", level.picture().key_count());
    }

    const Task& task_;
    const SynthesisOptions& options_;
    const ImageIo* images_;
    RunContext& run_;
    double stroke_px_;
    double texel_m_;
    int finest_;
    int halvings_;  ///< Halvings of the strokes' size for detail.
    Clock::time_point started_ = Clock::now();
    Clock::time_point saved_ = started_;
    Clock::time_point shown_ = Clock::now();
    double preview_took_ = 0;            ///< Seconds.
    texturing::TexelFaces shown_faces_;  ///< The texels of previews, from the first one on.
};

}  // namespace

Painting synthesize(const Task& task, const SynthesisOptions& options, const ImageIo* images, RunContext& run)
{
    return Synthesis(task, options, images, run).make();
}

}  // namespace fresco::synthesize
