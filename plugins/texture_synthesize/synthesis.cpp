#include "synthesis.h"

#include "checkpoint.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/geometry/topology.h>
#include <fresco/images/lab.h>
#include <fresco/images/stroke_width.h>
#include <fresco/numerics/noise.h>
#include <fresco/parallel.h>
#include <fresco/texturing/texel_faces.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

namespace fresco::synthesize
{
namespace
{

constexpr float vote_sigma = 0.35F;  // Of a side.
constexpr float epsilon = 1;         // L*a*b*²: patches that fit better than this count alike.
constexpr float power = -0.6F;

/// 1 in the middle of a patch, 0 from its border on, smooth between.
float to_border(float at, float side)
{
    const float t = std::clamp(4 * (0.5F - std::abs(at) / side), 0.0F, 1.0F);
    return t * t * (3 - 2 * t);
}

}  // namespace

float vote_weight(Vec2f offset, float side, float distance)
{
    const float gauss = std::exp(-dot(offset, offset) / (2 * vote_sigma * vote_sigma * side * side));
    return gauss * to_border(offset.x, side) * to_border(offset.y, side) * std::pow(distance + epsilon, power);
}

namespace
{

constexpr std::size_t texels_per_piece = 1U << 14U;
constexpr double texels_per_wave = 4;  // Of the noise that the start gets.

/// The texcoord of a texel's center.
Vec2f texcoord_of(const SurfaceGrid& grid, std::uint32_t chart, const SurfaceGrid::Texel& texel)
{
    const SurfaceGrid::Sheet& sheet = grid.sheet(chart);
    const std::size_t place = texel.cell - sheet.first_cell;
    const std::size_t column = place % static_cast<std::size_t>(sheet.width);
    const std::size_t row = place / static_cast<std::size_t>(sheet.width);
    return {static_cast<float>((static_cast<double>(column) - 0.5) / sheet.cells_per_uv + sheet.uv_low.x),
            static_cast<float>((static_cast<double>(row) - 0.5) / sheet.cells_per_uv + sheet.uv_low.y)};
}

template <class Work>
void for_each_texel(const SurfaceGrid& grid, const Progress& progress, const Work& work)
{
    parallel_for(grid.texels().size(), texels_per_piece, progress.threads(),
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     for (std::size_t t = begin; t < end; ++t)
                         work(t);
                 });
}

}  // namespace

Level::Level(const Task& task, double spacing_m, double scale, const LevelOptions& options, const Progress& progress)
    : task_(task), options_(options), grid_(task.surface, spacing_m, progress),
      patches_(task.surface, grid_, task.upright, options.side, options.stride, progress, task.lines),
      picture_(task.picture, scale, options.side, progress, task.lines.empty() ? 0 : options.search.stroke_px),
      start_(grid_.texels().size()), crowding_(picture_.key_count(), 1.0F)
{
    for_each_texel(grid_, progress,
                   [&](std::size_t t)
                   {
                       const SurfaceGrid::Texel& texel = grid_.texels()[t];
                       const std::uint32_t chart = task_.surface.charts.of_face[texel.face];
                       start_[t] = lab_from_rgb(
                           task_.start(chart, texcoord_of(grid_, chart, texel), 1 / grid_.sheet(chart).cells_per_uv));
                   });
}

std::uint32_t Level::texel_near(std::uint32_t chart, Vec2f uv) const
{
    const SurfaceGrid::Sheet& sheet = grid_.sheet(chart);
    const Vec2d at = grid_.place(chart, uv);
    const auto cell = [](double along, int count)
    { return static_cast<std::size_t>(std::clamp(static_cast<int>(std::floor(along)), 0, count - 1)); };
    return grid_.texel_at(sheet.first_cell + cell(at.y, sheet.height) * static_cast<std::size_t>(sheet.width) +
                          cell(at.x, sheet.width));
}

void Level::begin(const Level* coarser, const Progress& progress)
{
    colors_ = start_;
    if (coarser == nullptr)
    {
        const auto waves = static_cast<float>(1 / (texels_per_wave * grid_.spacing_m()));
        const auto amount = 2 * static_cast<float>(options_.unrest);
        for_each_texel(grid_, progress,
                       [&](std::size_t t)
                       {
                           const Vec3f at = grid_.texels()[t].position * waves;
                           const auto noise = [&](std::uint32_t field)
                           { return amount * smooth_noise(at, noise::hash(options_.search.seed, field)); };
                           colors_[t] += Vec3f{noise(1), noise(2) / 2, noise(3) / 2};
                       });
        return;
    }
    const auto ratio = static_cast<float>(picture_.scale() / coarser->picture().scale());
    for_each_texel(grid_, progress,
                   [&](std::size_t t)
                   {
                       const SurfaceGrid::Texel& texel = grid_.texels()[t];
                       const std::uint32_t chart = task_.surface.charts.of_face[texel.face];
                       const auto color = [&](Vec2f at) {
                           return picture_.color({(at.x + 0.5F) * ratio - 0.5F, (at.y + 0.5F) * ratio - 0.5F});
                       };
                       colors_[t] = coarser->vote_at(chart, texcoord_of(grid_, chart, texel), texel.position, color).mean;
                   });
}

void Level::resume(std::vector<Vec3f> colors, std::vector<Match> matches, std::vector<float> crowding)
{
    if (colors.size() != start_.size() || matches.size() != patches_.count() || crowding.size() != picture_.key_count())
        throw Error("it belongs to another surface or picture");
    const auto is_finite = [](Vec3f v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
    const auto is_match = [&](const Match& match)
    {
        return is_finite({match.at.x, match.at.y, match.distance}) && match.distance >= 0 &&
               std::abs(length(match.turn) - 1) < 1e-3F;
    };
    if (!std::all_of(colors.begin(), colors.end(), is_finite) || !std::all_of(matches.begin(), matches.end(), is_match) ||
        !std::all_of(crowding.begin(), crowding.end(), [](float v) { return std::isfinite(v) && v >= 1; }))
        throw Error("it has values that are not finite");
    colors_ = std::move(colors);
    matches_ = std::move(matches);
    crowding_ = std::move(crowding);
}

double Level::direction_error_deg(const Progress& progress) const
{
    const int side = patches_.side();
    std::vector<float> errors(patches_.count());
    parallel_for(
        errors.size(), 4096, progress.threads(),
        [&](std::size_t begin, std::size_t end)
        {
            progress.check_canceled();
            std::vector<Vec3f> samples(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
            const auto light = [&](int x, int y)
            { return samples[static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x)].x; };
            for (std::size_t i = begin; i < end; ++i)
            {
                patches_.sample(grid_, colors_, i, samples.data());
                Vec2f twice;
                for (int y = 1; y + 1 < side; ++y)
                    for (int x = 1; x + 1 < side; ++x)
                    {
                        const float across = light(x + 1, y) - light(x - 1, y);
                        const float along = light(x, y + 1) - light(x, y - 1);
                        twice = twice + Vec2f{along * along - across * across, -2 * across * along};
                    }
                errors[i] = std::abs(std::atan2(twice.y, twice.x)) / 2;
            }
        });
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    return double{*middle} * 180 / std::numbers::pi;
}

void Level::paint_round(const Progress& progress)
{
    const auto g = static_cast<float>(options_.faithfulness);
    std::vector<Vec3f> wanted(colors_.size());
    for_each_texel(grid_, progress, [&](std::size_t t) { wanted[t] = colors_[t] * (1 - g) + start_[t] * g; });
    matches_ = search(patches_, grid_, wanted, picture_, options_.search, crowding_, progress);
    update_crowding(picture_, matches_, crowding_);
    for_each_texel(grid_, progress,
                   [&](std::size_t t)
                   {
                       colors_[t] = vote(
                                        patches_.covers(t), matches_, options_.side, [](std::uint32_t) { return Vec2f{}; },
                                        [&](Vec2f at) { return picture_.color(at); })
                                        .mean;
                   });
}

namespace
{

constexpr std::size_t rows_per_piece = 16;
constexpr float heaviest_share = 0.75F;  // Of the luminance.

/// RGB in [0,1]: the mean's color, lightened or darkened toward the heaviest patch's luminance (Rec. 709, of displayed values).
Vec3f mixed(const Vote& vote)
{
    const float lighter = heaviest_share * dot(Vec3f{0.2126F, 0.7152F, 0.0722F}, vote.heaviest - vote.mean);
    const auto clamped = [lighter](float v) { return std::clamp(v + lighter, 0.0F, 1.0F); };
    return {clamped(vote.mean.x), clamped(vote.mean.y), clamped(vote.mean.z)};
}

/// RGB in [0,1] of an 8-bit picture at a place, bilinear, pixel centers at whole numbers.
Vec3f color_at(const Raster8& rgb, Vec2f at)
{
    const float x = std::clamp(at.x, 0.0F, static_cast<float>(rgb.width - 1));
    const float y = std::clamp(at.y, 0.0F, static_cast<float>(rgb.height - 1));
    const int x0 = static_cast<int>(x);
    const int y0 = static_cast<int>(y);
    const int x1 = std::min(x0 + 1, rgb.width - 1);
    const int y1 = std::min(y0 + 1, rgb.height - 1);
    const float fx = x - static_cast<float>(x0);
    const float fy = y - static_cast<float>(y0);
    const auto value = [&rgb](int column, int row)
    {
        const std::uint8_t* v = &rgb.at(column, row);
        return Vec3f{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
    };
    const Vec3f top = value(x0, y0) * (1 - fx) + value(x1, y0) * fx;
    const Vec3f bottom = value(x0, y1) * (1 - fx) + value(x1, y1) * fx;
    return (top * (1 - fy) + bottom * fy) * (1 / 255.0F);
}

}  // namespace

Painting paint(const Task& task, const Level& level, int size_px, Progress& progress)
{
    const Mesh& mesh = task.surface.mesh;
    const texturing::TexelFaces faces = texturing::find_texel_faces(mesh, task.surface.charts, size_px, progress);
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

    // Of the style picture: its pixels along a texel, and how much it is made smaller for that.
    const double pixels_per_texel = texel_m / level.grid().spacing_m() / level.picture().scale();
    const double scale = std::min(1.0, 1 / pixels_per_texel);
    const Raster8 picture = resized(task.picture, std::max(1, static_cast<int>(std::lround(task.picture.width * scale))),
                                    std::max(1, static_cast<int>(std::lround(task.picture.height * scale))));
    const RasterF& searched = level.picture().lab();
    const Vec2f to_picture{static_cast<float>(picture.width) / static_cast<float>(searched.width),
                           static_cast<float>(picture.height) / static_cast<float>(searched.height)};

    Painting result;
    const std::string atlas = atlas_id(mesh);
    result.texture.atlas = atlas;
    result.texture.layers.emplace_back(size_px, size_px, 3);
    result.texture.seen = Raster8(size_px, size_px);
    result.source.atlas = atlas;
    result.source.picture_width = task.picture.width;
    result.source.picture_height = task.picture.height;
    result.source.pixels_per_texel = static_cast<float>(pixels_per_texel);
    result.source.places = Raster16(size_px, size_px, 3, SourceMap::none);

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
        const Vote vote = level.vote_at(
            chart, uv, texturing::texel_position(mesh, faces, texel),
            [&](Vec2f at) {
                return color_at(picture, {(at.x + 0.5F) * to_picture.x - 0.5F, (at.y + 0.5F) * to_picture.y - 0.5F});
            });
        float* out = &result.texture.layers[0].at(x, y);
        const Vec3f color = mixed(vote);
        out[0] = color.x;
        out[1] = color.y;
        out[2] = color.z;
        result.texture.seen.at(x, y) = 1;
        const TangentFrame& frame = level.patches()[vote.patch].frame;
        const Vec3f right = texcoord_axes(mesh, face).first;
        const Match& match = level.matches()[vote.patch];
        const Vec2f at = match.place(vote.offset);
        const Vec2f in_picture = turned({dot(right, frame.right), dot(right, frame.down)}, match.turn);
        result.source.set_place(x, y,
                                {{(at.x + 0.5F) * static_cast<float>(task.picture.width) / static_cast<float>(searched.width),
                                  (at.y + 0.5F) * static_cast<float>(task.picture.height) / static_cast<float>(searched.height)},
                                 std::atan2(in_picture.y, in_picture.x)});
    };
    std::size_t rows_done = 0;
    constexpr int rows_per_step = 256;
    for (int first = 0; first < size_px; first += rows_per_step)
    {
        const int rows = std::min(rows_per_step, size_px - first);
        parallel_for(static_cast<std::size_t>(rows), rows_per_piece, progress.threads(),
                     [&](std::size_t begin, std::size_t end)
                     {
                         progress.check_canceled();
                         for (std::size_t y = begin; y < end; ++y)
                             for (int x = 0; x < size_px; ++x)
                                 paint_texel(x, first + static_cast<int>(y));
                     });
        rows_done += static_cast<std::size_t>(rows);
        progress.progress(static_cast<double>(rows_done), size_px, "rows");
    }
    return result;
}

namespace
{

constexpr double least_texels = 2;
constexpr const char* check_unit = "; if the mesh is not in meters, read it with scan.mesh, which has the option unit_m";

double longest_side_m(const Mesh& mesh)
{
    Vec3f low = mesh.positions[mesh.triangles[0][0]];
    Vec3f high = low;
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle)
        {
            const Vec3f p = mesh.positions[corner];
            low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
        }
    return double{std::max({high.x - low.x, high.y - low.y, high.z - low.z})};
}

}  // namespace

double mean_texel_m(const Mesh& mesh, int size_px)
{
    double area = 0;
    double uv_area = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    {
        const Vec2f* uv = &mesh.texcoords[3 * f];
        const Vec2d a{double{uv[1].x} - uv[0].x, double{uv[1].y} - uv[0].y};
        const Vec2d b{double{uv[2].x} - uv[0].x, double{uv[2].y} - uv[0].y};
        uv_area += std::abs(cross(a, b));
        area += length(geometry::area_vector(mesh, f));
    }
    if (!(uv_area > 0) || !(area > 0))
        throw Error("the charts of the mesh on port 'mesh' have no area: wire an atlas.* stage");
    return std::sqrt(area / uv_area) / size_px;
}

double stroke_width_m(const Mesh& mesh, double wanted_m, double texel_m)
{
    constexpr double room_m = 3;
    constexpr double in_room_m = 0.035;
    const double longest_m = longest_side_m(mesh);
    if (wanted_m == 0)
        return std::max(least_texels * texel_m, in_room_m * std::min(1.0, longest_m / room_m));
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

constexpr double stroke_texels = 8;   // In the finest level.
constexpr double finest_texel = 0.6;  // Levels with texels smaller than this share of the texture's are left out.
constexpr int coarse_stride = 3;
constexpr int fine_stride = 4;
constexpr int preview_px = 512;

class Synthesis
{
  public:
    Synthesis(const Task& task, const SynthesisOptions& options, const ImageIo* images, RunContext& run)
        : task_(task), options_(options), images_(images), run_(run), stroke_px_(stroke_width_px(task.picture, run)),
          texel_m_(mean_texel_m(task.surface.mesh, options.size_px)), file_(run.checkpoint_folder() / "round.bin")
    {
    }

    Painting make()
    {
        const int finest = finest_level();
        std::unique_ptr<Level> level;
        int number = options_.levels_count - 1;
        if (std::optional<Checkpoint> found = earlier(finest))
        {
            auto next = new_level(found->level);
            if (resume(*next, *found))
            {
                level = std::move(next);
                paint_rounds(*level, found->level, found->rounds, finest);
                number = found->level - 1;
            }
        }
        for (; number >= finest; --number)
        {
            auto next = new_level(number);
            next->begin(level.get(), run_);
            level = std::move(next);
            paint_rounds(*level, number, 0, finest);
        }
        report(*level, finest);
        if (!task_.lines.empty())
            run_.report("direction_error_deg", level->direction_error_deg(run_));
        return paint(task_, *level, options_.size_px, run_);
    }

  private:
    using Clock = std::chrono::steady_clock;

    double spacing_m(int level) const { return options_.stroke_m / stroke_texels * std::exp2(level); }
    double scale(int level) const { return stroke_texels / stroke_px_ / std::exp2(level); }

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
                .stride = level > 0 ? coarse_stride : fine_stride,
                .faithfulness = 0.5 * std::pow(0.3, options_.painterly),
                .unrest = 10 * freedom,
                .search = {.completeness = options_.completeness,
                           .stroke_px = stroke_texels / std::exp2(level),
                           .variety = 5 * freedom,
                           .lift = 8 * freedom,
                           .seed = options_.seed}};
    }

    std::unique_ptr<Level> new_level(int number) const
    {
        return std::make_unique<Level>(task_, spacing_m(number), scale(number), level_options(number), run_);
    }

    std::optional<Checkpoint> earlier(int finest) const
    {
        try
        {
            auto found = read_checkpoint(file_);
            if (found && (found->level < finest || found->level >= options_.levels_count || found->rounds < 1 ||
                          found->rounds > options_.rounds_count))
                throw Error(file_.string() + ": belongs to another run");
            return found;
        }
        catch (const Error& error)
        {
            run_.warning(std::string("the checkpoint cannot be used: ") + error.what());
            return std::nullopt;
        }
    }

    bool resume(Level& level, Checkpoint& found) const
    {
        try
        {
            level.resume(std::move(found.colors), std::move(found.matches), std::move(found.crowding));
        }
        catch (const Error& error)
        {
            run_.warning("the checkpoint cannot be used: " + file_.string() + ": " + error.what());
            return false;
        }
        run_.message(fmt::format("going on after round {} of an interrupted run", found.rounds));
        return true;
    }

    void paint_rounds(Level& level, int number, int done, int finest)
    {
        const int rounds_in_all = (options_.levels_count - finest) * options_.rounds_count;
        for (int round = done; round < options_.rounds_count; ++round)
        {
            run_.progress((options_.levels_count - 1 - number) * options_.rounds_count + round, rounds_in_all, "rounds");
            level.paint_round(run_);
            double sum = 0;
            for (const Match& match : level.matches())
                sum += static_cast<double>(match.distance);
            run_.metric("distance", sum / static_cast<double>(level.matches().size()));
            const auto now = Clock::now();
            const auto since = [now](Clock::time_point then) { return std::chrono::duration<double>(now - then).count(); };
            if (options_.checkpoint_seconds > 0 && since(saved_) >= options_.checkpoint_seconds)
            {
                write_checkpoint(file_, {number, round + 1, level.colors(), level.matches(), level.crowding()});
                saved_ = Clock::now();
            }
            if (images_ != nullptr && since(shown_) >= options_.preview_seconds)
            {
                show(level);
                shown_ = Clock::now();
            }
        }
    }

    void show(const Level& level) const
    {
        const Painting small = paint(task_, level, std::min(preview_px, options_.size_px), run_);
        const RasterF& layer = small.texture.layers.front();
        Raster8 picture(layer.width, layer.height, 3);
        std::transform(layer.values.begin(), layer.values.end(), picture.values.begin(),
                       [](float v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0F, 1.0F) * 255)); });
        write_file(run_.preview_folder() / "texture.png", images_->encode_png(picture));
    }

    void report(const Level& level, int finest) const
    {
        const double pixel_cm = 100 * options_.stroke_m / stroke_px_;
        const double longest_cm = 100 * longest_side_m(task_.surface.mesh);
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
        run_.report("searched_texel_mm", 1000 * spacing_m(finest));
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
    std::filesystem::path file_;
    Clock::time_point saved_ = Clock::now();
    Clock::time_point shown_ = Clock::now();
};

}  // namespace

Painting synthesize(const Task& task, const SynthesisOptions& options, const ImageIo* images, RunContext& run)
{
    return Synthesis(task, options, images, run).make();
}

}  // namespace fresco::synthesize
