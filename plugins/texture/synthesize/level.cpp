#include "level.h"

#include <fresco/images/lab.h>
#include <fresco/numerics/noise.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fresco::synthesize
{
namespace
{

constexpr float vote_sigma = 0.35F;  // Share of a side.
constexpr float epsilon = 1;         // L*a*b*²: patches that fit better than this count alike.
constexpr float power = -0.6F;

}  // namespace

Window::Window(int side)
{
    for (int i = 0; static_cast<float>(i) <= static_cast<float>(side) / 2 * steps + 1; ++i)
    {
        const float at = static_cast<float>(i) / steps / static_cast<float>(side);
        // 1 in the middle, 0 from the border on, smooth between.
        const float t = std::clamp(4 * (0.5F - at), 0.0F, 1.0F);
        values_.push_back(std::exp(-at * at / (2 * vote_sigma * vote_sigma)) * t * t * (3 - 2 * t));
    }
}

namespace
{

constexpr int small_face_rings = 2;
constexpr std::size_t texels_per_piece = 1U << 14U;
constexpr double texels_per_wave = 4;  // Wavelength of the noise that is added to the start.

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
    parallel_items(grid.texels().size(), texels_per_piece, progress, work);
}

}  // namespace

Level::Level(const Task& task, double spacing_m, double scale, const LevelOptions& options, const Progress& progress,
             Level* under)
    : Level(task, spacing_m, scale, options, progress, under,
            under != nullptr ? under->unshown(options.least_missing, progress) : Unshown{})
{
}

Level::Level(const Task& task, double spacing_m, double scale, const LevelOptions& options, const Progress& progress,
             const Level* under, const Unshown& unshown)
    : task_(task), options_(options), under_(under), grid_(task.surface, spacing_m, progress, unshown.faces),
      share_(under != nullptr ? share_over(unshown, progress) : std::vector<float>()),
      patches_(task.surface, grid_, task.upright, options.side, options.stride, progress, task.lines, share_),
      window_(options.side),
      picture_(task.picture, scale, options.side, progress, task.lines.empty() ? 0 : options.search.stroke_px, task.opaque),
      start_(grid_.texels().size()), uses_(patches_, grid_, picture_, options.search.stroke_px, progress),
      crowding_(picture_.key_count(), 1.0F)
{
    grid_.forget_faces();  // Its patches have walked over them.
    const auto painted = [](const Level& level, Vec2f at) { return level.picture().color(at); };
    const std::vector<std::uint8_t> sampled =
        under_ != nullptr ? patches_.sampled(grid_, progress) : std::vector<std::uint8_t>(start_.size(), 1);
    for_each_texel(grid_, progress,
                   [&](std::size_t t)
                   {
                       if (sampled[t] == 0)
                           return;
                       const SurfaceGrid::Texel& texel = grid_.texels()[t];
                       const std::uint32_t chart = task_.surface.charts.of_face[texel.face];
                       const Vec2f uv = texcoord_of(grid_, chart, texel);
                       start_[t] = lab_from_rgb(task_.start(chart, uv, 1 / grid_.sheet(chart).cells_per_uv));
                       if (under_ != nullptr && share_[t] < 1)
                           start_[t] = start_[t] * share_[t] +
                                       under_->vote_at(chart, uv, texel.position, painted).shifted_mean() * (1 - share_[t]);
                   });
}

std::vector<float> Level::share_over(const Unshown& unshown, const Progress& progress) const
{
    std::vector<float> share(grid_.texels().size());
    for_each_texel(grid_, progress,
                   [&](std::size_t t)
                   {
                       const SurfaceGrid::Texel& texel = grid_.texels()[t];
                       const std::uint32_t chart = task_.surface.charts.of_face[texel.face];
                       share[t] = unshown.share[under_->texel_near(chart, texcoord_of(grid_, chart, texel))];
                   });
    return share;
}

Level::Unshown Level::unshown(double least_missing, const Progress& progress)
{
    Unshown result{missing(progress), std::vector<std::uint8_t>(task_.surface.mesh.triangles.size(), 0)};
    std::vector<std::uint8_t> near(patches_.count(), 0);
    for (std::size_t t = 0; t < result.share.size(); ++t)
    {
        const float x = std::clamp(result.share[t] / static_cast<float>(least_missing) - 1, 0.0F, 1.0F);
        result.share[t] = x * x * (3 - 2 * x);
        if (x > 0)
            for (const std::uint32_t patch : patches_.covers(t))
                near[patch] = 1;
    }
    for (std::size_t t = 0; t < result.share.size(); ++t)
        if (std::ranges::any_of(patches_.covers(t), [&](std::uint32_t patch) { return near[patch] != 0; }))
            result.faces[grid_.texels()[t].face] = 1;
    // Small faces may hold no texel of this level.
    for (int ring = 0; ring < small_face_rings; ++ring)
    {
        const std::vector<std::uint8_t> before = result.faces;
        for (std::size_t face = 0; face < before.size(); ++face)
            for (const std::uint32_t other : task_.surface.neighbors[face])
                if (before[face] != 0 && other != geometry::none)
                    result.faces[other] = 1;
    }
    settle();
    return result;
}

void Level::settle()
{
    patches_.forget_points();
    picture_.forget_means();
    start_ = std::vector<Vec3f>();
    colors_ = std::vector<Vec3f>();
    uses_ = {};
    give_back_memory();
}

std::vector<float> Level::missing(const Progress& progress) const
{
    const int side = patches_.side();
    const std::size_t points = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    std::vector<float> window(points);
    for (std::size_t i = 0; i < points; ++i)
    {
        const int middle = side / 2;
        const auto at = [&](std::size_t along) { return static_cast<float>(along) - static_cast<float>(middle); };
        window[i] = window_({at(i % static_cast<std::size_t>(side)), at(i / static_cast<std::size_t>(side))});
    }
    const float total = std::accumulate(window.begin(), window.end(), 0.0F);
    std::vector<float> of_patch(patches_.count());
    parallel_for(of_patch.size(), 4096, progress,
                 [&](std::size_t begin, std::size_t end)
                 {
                     progress.check_canceled();
                     std::vector<Vec3f> wanted(points);
                     std::vector<Vec3f> painted(points);
                     const auto center = [&](std::vector<Vec3f>& values)
                     {
                         Vec3f mean;
                         for (std::size_t i = 0; i < points; ++i)
                             mean += values[i] * (window[i] / total);
                         for (Vec3f& value : values)
                             value = value - mean;
                     };
                     for (std::size_t p = begin; p < end; ++p)
                     {
                         patches_.sample(grid_, start_, p, wanted.data());
                         patches_.sample(grid_, colors_, p, painted.data());
                         center(wanted);
                         center(painted);
                         float own = 0;
                         float common = 0;
                         float all = 0;
                         for (std::size_t i = 0; i < points; ++i)
                         {
                             own += window[i] / total * dot(wanted[i], wanted[i]);
                             common += window[i] / total * dot(wanted[i], painted[i]);
                             all += window[i] / total * dot(painted[i], painted[i]);
                         }
                         if (own <= 0)
                             continue;
                         const float slope = std::clamp(common / own, 0.0F, 1.0F);
                         const float strokes = std::max(0.0F, all - slope * (2 * common - slope * own));
                         of_patch[p] = std::sqrt(own) * (1 - slope) * own / (own + strokes);
                     }
                 });
    std::vector<float> result(start_.size(), 0.0F);
    for_each_texel(grid_, progress,
                   [&](std::size_t t)
                   {
                       float sum = 0;
                       float weights = 0;
                       for (const std::uint32_t patch : patches_.covers(t))
                       {
                           const Vec2f offset = patches_.offset(patch, grid_.texels()[t].position);
                           const float weight = window_(offset);
                           sum += weight * of_patch[patch];
                           weights += weight;
                       }
                       result[t] = weights > 0 ? sum / weights : 0;
                   });
    return result;
}

std::uint32_t Level::texel_near(std::uint32_t chart, Vec2f uv) const
{
    const SurfaceGrid::Sheet& sheet = grid_.sheet(chart);
    const Vec2d at = grid_.place(chart, uv);
    return grid_.texel_at(sheet.cell(sheet.column(at.x), sheet.row(at.y)));
}

void Level::begin(const Level* coarser, const Progress& progress)
{
    colors_ = start_;
    if (under_ != nullptr)
        return;
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
    const auto here = [ratio](Vec2f at) { return Vec2f{(at.x + 0.5F) * ratio - 0.5F, (at.y + 0.5F) * ratio - 0.5F}; };
    const auto vote_on = [&](std::size_t t)
    {
        const SurfaceGrid::Texel& texel = grid_.texels()[t];
        const std::uint32_t chart = task_.surface.charts.of_face[texel.face];
        return coarser->vote_at(chart, texcoord_of(grid_, chart, texel), texel.position,
                                [&](const Level&, Vec2f at) { return picture_.color(here(at)); });
    };
    for_each_texel(grid_, progress, [&](std::size_t t) { colors_[t] = vote_on(t).shifted_mean(); });
    matches_.resize(patches_.count());
    parallel_items(matches_.size(), texels_per_piece, progress,
                   [&](std::size_t p)
                   {
                       const LevelVote vote = vote_on(patches_[p].texel);
                       matches_[p] = coarser->matches()[vote.patch];
                       matches_[p].at = picture_.inside(here(matches_[p].place(vote.offset)));
                   });
}

void Level::resume(std::vector<Match> matches, std::vector<float> crowding, const Progress& progress)
{
    crowding_ = std::move(crowding);
    set_matches(std::move(matches));
    vote_colors(progress);
}

void Level::set_matches(std::vector<Match> matches)
{
    matches_ = std::move(matches);
    fits_.resize(matches_.size());
    std::ranges::transform(matches_, fits_.begin(), [](const Match& match) { return std::pow(match.distance + epsilon, power); });
}

void Level::vote_colors(const Progress& progress)
{
    colors_.resize(start_.size());
    for_each_texel(grid_, progress,
                   [&](std::size_t t)
                   {
                       const auto offset_on = [&](std::uint32_t patch)
                       { return patches_.offset(patch, grid_.texels()[t].position); };
                       const auto color = [&](Vec2f at) { return picture_.color(at); };
                       // Texels without patches are not painted: there the start remains.
                       colors_[t] = patches_.covers(t).empty()
                                        ? start_[t]
                                        : vote(patches_.covers(t), matches_, fits_, window_, offset_on, color).shifted_mean();
                   });
}

void Level::paint_round(Round round, const Progress& progress, bool is_voted)
{
    const auto g = static_cast<float>(options_.faithfulness);
    std::vector<Vec3f>& wanted = colors_;
    for_each_texel(grid_, progress, [&](std::size_t t) { wanted[t] = colors_[t] * (1 - g) + start_[t] * g; });
    set_matches(search(patches_, grid_, wanted, picture_, uses_, options_.search, round, matches_, crowding_, progress));
    if (is_voted)
        vote_colors(progress);
    update_crowding(picture_, matches_, crowding_);
}

}  // namespace fresco::synthesize
