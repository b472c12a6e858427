#pragma once

#include "samples.h"
#include "synthesis.h"

#include <fresco/images/filters.h>
#include <fresco/images/lab.h>
#include <fresco/numerics/noise.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

/// \file One level of a synthesis on a flat wall as its description says it: slow, on one thread, mostly in double precision.
/// Texels, patches, the picture's keys with their principal components, random preferences and noise are those of the code under
/// test, and have tests of their own.

namespace plain
{

using namespace fresco;
using namespace fresco::synthesize;

using Numbers = std::vector<double>;
using Look = std::vector<Vec3f>;  ///< The colors of a patch.

inline Vec3d mean_of(const Look& look)
{
    Vec3d sum;
    for (const Vec3f color : look)
        sum += vec_cast<double>(color);
    return sum * (1 / static_cast<double>(look.size()));
}

/// The color of a point, and the patch that counts most in it.
struct Mixed
{
    Vec3d color;
    Vec3d shift;  ///< Shift of the mean.
    Vec3d heaviest_color;
    Vec2f place;  ///< The point on the heaviest patch, in the level's picture.
};

/// Inputs and results of a search.
struct Searched
{
    std::vector<Match> found;
    std::vector<Look> looks;  ///< Per patch, what is looked for.
    Numbers weights;          ///< Per key.
    Numbers unavoidable;      ///< Per patch.
    std::vector<Match> uses;  ///< Uses that the last pass charged for.
};

class PlainLevel
{
  public:
    PlainLevel(const Task& task, const Level& level, const LevelOptions& options)
        : task_(task), options_(options), grid_(level.grid()), patches_(level.patches()), picture_(level.picture()),
          stroke_px_(options.search.stroke_px),
          variety_(patches_, grid_, picture_, stroke_px_, options.search.variety, options.search.seed, Progress()),
          motifs_(motifs())
    {
    }

    std::vector<Vec3f> start() const
    {
        std::vector<Vec3f> result;
        for (std::uint32_t t = 0; t < grid_.texels().size(); ++t)
            result.push_back(lab_from_rgb(task_.start(chart(t), texcoord(t), 1 / grid_.sheet(chart(t)).cells_per_uv)));
        return result;
    }

    /// The start with noise.
    std::vector<Vec3f> begin_alone() const
    {
        std::vector<Vec3f> result = start();
        for (std::size_t t = 0; t < result.size(); ++t)
        {
            const Vec3f at = grid_.texels()[t].position * static_cast<float>(1 / (4 * grid_.spacing_m()));
            const auto unrest = [&](std::uint32_t field)
            { return 2 * static_cast<float>(options_.unrest) * smooth_noise(at, noise::hash(options_.search.seed, field)); };
            result[t] += Vec3f{unrest(1), unrest(2) / 2, unrest(3) / 2};
        }
        return result;
    }

    /// Start from the patches of a coarser level, with this level's colors.
    std::vector<Vec3f> begin_after(const PlainLevel& coarser, const std::vector<Match>& matches) const
    {
        const auto ratio = static_cast<float>(picture_.scale() / coarser.picture_.scale());
        const auto color = [&](Vec2f at) { return picture_.color({(at.x + 0.5F) * ratio - 0.5F, (at.y + 0.5F) * ratio - 0.5F}); };
        std::vector<Vec3f> result;
        for (std::uint32_t t = 0; t < grid_.texels().size(); ++t)
        {
            const Mixed vote =
                coarser.mixed(coarser.texel_near(chart(t), texcoord(t)), grid_.texels()[t].position, matches, color);
            result.push_back(vec_cast<float>(vote.color + vote.shift));
        }
        return result;
    }

    /// The places that the patches of a coarser level show at the centers of this level's patches.
    std::vector<Vec2f> places_after(const PlainLevel& coarser, const std::vector<Match>& matches) const
    {
        const auto ratio = static_cast<float>(picture_.scale() / coarser.picture_.scale());
        const auto here = [ratio](Vec2f at) { return Vec2f{(at.x + 0.5F) * ratio - 0.5F, (at.y + 0.5F) * ratio - 0.5F}; };
        std::vector<Vec2f> result;
        for (std::size_t p = 0; p < patches_.count(); ++p)
        {
            const std::uint32_t t = patches_[p].texel;
            const Mixed vote = coarser.mixed(coarser.texel_near(chart(t), texcoord(t)), grid_.texels()[t].position, matches,
                                             [&](Vec2f at) { return picture_.color(here(at)); });
            result.push_back(picture_.inside(here(vote.place)));
        }
        return result;
    }

    /// A round's search.
    Searched search(Round round, const std::vector<Vec3f>& colors, const Numbers& crowding,
                    const std::vector<Match>& before) const
    {
        const std::vector<Vec3f> begun = start();
        const auto share = static_cast<float>(options_.faithfulness);
        std::vector<Vec3f> wanted;
        for (std::size_t t = 0; t < colors.size(); ++t)
            wanted.push_back(colors[t] * (1 - share) + begun[t] * share);
        Searched result;
        std::vector<float> features(patches_.count() * picture_.feature_count());
        for (std::size_t p = 0; p < patches_.count(); ++p)
        {
            Look& look = result.looks.emplace_back(picture_.values_per_patch() / 3);
            patches_.sample(grid_, wanted, p, look.data());
            picture_.project(&look[0].x, 1, &features[p * picture_.feature_count()]);
        }
        result.weights = key_weights(features, crowding);
        for (std::size_t p = 0; p < patches_.count(); ++p)
        {
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t k = 0; k < picture_.key_count(); ++k)
                if (k == 0 || noise::hash(static_cast<std::uint32_t>(k / 8)) % 8 == k % 8)
                    least = std::min(least, squared_distance(&features[p * picture_.feature_count()], k));
            result.unavoidable.push_back(least / 2 / static_cast<double>(picture_.values_per_patch()));
        }
        // In the first round of all, all patches choose at once; then, in every one, three parts in turn.
        std::vector<Match> chosen = before;
        for (std::uint32_t turn = before.empty() ? 0 : 1; round != Round::refines && turn <= 3; ++turn)
        {
            const std::vector<Match> seen = chosen;
            chosen.resize(patches_.count());
            for (std::uint32_t p = 0; p < patches_.count(); ++p)
                if (turn == 0 || noise::hash(options_.search.seed + 1, p) % 3 == turn - 1)
                    chosen[p] = {.at = best_key(p, &features[p * picture_.feature_count()], result, seen)};
        }
        for (std::size_t p = 0; p < patches_.count(); ++p)
            if (round == Round::refines)
                result.found.push_back(
                    {.at = before[p].at, .distance = static_cast<float>(distance_of(result.looks[p], before[p].at))});
            else
                result.found.push_back(refined(result.looks[p], chosen[p].at));
        for (int pass = 0; pass < 3; ++pass)
        {
            result.uses = result.found;
            for (std::size_t p = 0; p < patches_.count(); ++p)
                result.found[p] = continued(p, result, pass == 0);
        }
        return result;
    }

    /// The prices after a round: they follow the square root of the use around a key in times 3 the mean, and never fall
    /// below 1.
    Numbers crowded(const Numbers& before, const std::vector<Match>& matches) const
    {
        Numbers result;
        for (std::size_t k = 0; k < before.size(); ++k)
            result.push_back(std::max(1.0, before[k] * std::sqrt(use_around(picture_.key(k), matches) / 3)));
        return result;
    }

    /// Cost of a place of the picture for a patch; its own place, which nothing continues, costs more.
    double score(std::size_t patch, const Searched& searched, Vec2f at, bool is_own) const
    {
        const double lift = options_.search.lift;
        const double distance = std::max(0.0, distance_of(searched.looks[patch], at) - searched.unavoidable[patch]);
        return score(patch, is_own ? 2 * (distance + 15 + lift) - lift : distance, at, searched.weights, searched.uses);
    }

    /// Patches that show a place of the picture around a patch, other than the copy that it belongs to.
    NearbyUses::Copies copies(std::size_t patch, Vec2f at, const std::vector<Match>& matches) const
    {
        const auto away = [](float a, float b, double unit) { return std::abs(std::floor(a / unit) - std::floor(b / unit)); };
        const auto is_from = [&](float v, float of)
        {
            const double cells = std::floor(v / (stroke_px_ / 2)) - std::floor(of / (stroke_px_ / 2) + 0.5);
            return cells == -1 || cells == 0;
        };
        const auto over = patches_.covers(patches_[patch].texel);
        const Vec3f a = patches_[patch].center;
        double patches = 0;
        NearbyUses::Copies result;
        for (std::uint32_t q = 0; q < matches.size(); ++q)
        {
            patches += static_cast<double>(patches_.covers(patches_[q].texel).size());
            const Vec2f offset = patches_.offset(q, a);
            const bool is_own = std::ranges::find(over, q) != over.end() &&
                                (q == patch || length(matches[q].at + offset - at) <= length(offset) / 2);
            if (is_own || !is_from(matches[q].at.x, at.x) || !is_from(matches[q].at.y, at.y))
                continue;
            const double block_m = 2 * stroke_px_ * grid_.spacing_m();
            const Vec3f b = patches_[q].center;
            const double blocks = std::max({away(a.x, b.x, block_m), away(a.y, b.y, block_m), away(a.z, b.z, block_m)});
            result.around += blocks <= 4 ? 1 : 0;
            result.beside += blocks <= 1 ? 1 : 0;
        }
        const auto per_copy =
            static_cast<float>(patches / static_cast<double>(matches.size()) * std::pow(stroke_px_ / patches_.side(), 2));
        return {result.around / per_copy, result.beside / per_copy};
    }

    /// The mean of the patches over each texel.
    std::vector<Vec3f> voted(const std::vector<Match>& matches) const
    {
        std::vector<Vec3f> result;
        for (std::uint32_t t = 0; t < grid_.texels().size(); ++t)
        {
            const Mixed vote = mixed(t, grid_.texels()[t].position, matches, [&](Vec2f at) { return picture_.color(at); });
            result.push_back(vec_cast<float>(vote.color + vote.shift));
        }
        return result;
    }

    struct Texel
    {
        Vec3f rgb;
        Vec3f shift;  ///< Shift in RGB.
        Vec2f place;  ///< Place of the heaviest patch, in pixels of the style picture, pixel centers at +0.5.
    };

    /// The covered texels of a texture, by their numbers: the mean, with three quarters of the heaviest patch's luminance.
    std::map<std::size_t, Texel> texture(int size_px, const std::vector<Match>& matches) const
    {
        const Mesh& mesh = task_.surface.mesh;
        const auto faces = texturing::find_texel_faces(mesh, task_.surface.charts, size_px, Progress());
        // All charts have one scale. Pixels of the style picture along a texel:
        const double pixels = 1 / (task_.surface.uv_per_m[0] * size_px) / grid_.spacing_m() / picture_.scale();
        const auto shrunk = [&](int length) { return static_cast<int>(std::lround(length / std::max(pixels, 1.0))); };
        const Raster8 style = resized(task_.picture, shrunk(task_.picture.width), shrunk(task_.picture.height));
        const auto to = [&](const Raster8& picture, Vec2f at)
        {
            return Vec2f{(at.x + 0.5F) * static_cast<float>(picture.width) / static_cast<float>(picture_.lab().width),
                         (at.y + 0.5F) * static_cast<float>(picture.height) / static_cast<float>(picture_.lab().height)};
        };
        const ColorLookup<std::uint8_t> colors(style);
        const auto color = [&](Vec2f at) { return colors(to(style, at) - Vec2f{0.5F, 0.5F}) * (1 / 255.0F); };
        std::map<std::size_t, Texel> result;
        for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        {
            if (!faces.covered(texel))
                continue;
            const Vec2f uv = samples::texcoord(size_px, static_cast<int>(texel) % size_px, static_cast<int>(texel) / size_px);
            const std::uint32_t near = texel_near(task_.surface.charts.of_face[faces.face[texel]], uv);
            const Mixed vote = mixed(near, texturing::texel_position(mesh, faces, texel), matches, color);
            const double lighter = 0.75 * dot(Vec3d{0.2126, 0.7152, 0.0722}, vote.heaviest_color - vote.color);
            const auto clamped = [lighter](double v) { return std::clamp(v + lighter, 0.0, 1.0); };
            const Vec3f copied = vec_cast<float>(Vec3d{clamped(vote.color.x), clamped(vote.color.y), clamped(vote.color.z)});
            const Vec3f rgb = rgb_from_lab(lab_from_rgb(copied) + vec_cast<float>(vote.shift));
            result[texel] = {rgb, rgb - copied, to(task_.picture, vote.place)};
        }
        return result;
    }

  private:
    std::uint32_t chart(std::uint32_t texel) const { return task_.surface.charts.of_face[grid_.texels()[texel].face]; }

    Vec2f texcoord(std::uint32_t texel) const
    {
        const SurfaceGrid::Sheet& sheet = grid_.sheet(chart(texel));
        const auto cell = static_cast<int>(grid_.texels()[texel].cell - sheet.first_cell);
        return {static_cast<float>((cell % sheet.width - 0.5) / sheet.cells_per_uv + sheet.uv_low.x),
                static_cast<float>((cell / sheet.width - 0.5) / sheet.cells_per_uv + sheet.uv_low.y)};
    }

    std::uint32_t texel_near(std::uint32_t chart, Vec2f uv) const
    {
        const SurfaceGrid::Sheet& sheet = grid_.sheet(chart);
        const Vec2d at = grid_.place(chart, uv);
        return grid_.texel_at(sheet.cell(sheet.column(at.x), sheet.row(at.y)));
    }

    Look copy(Vec2f at) const
    {
        Look result;
        const int side = picture_.side();
        for (int i = 0; i < side * side; ++i)
        {
            const float* lab = &picture_.lab().at(static_cast<int>(std::lround(at.x)) + i % side - side / 2,
                                                  static_cast<int>(std::lround(at.y)) + i / side - side / 2);
            result.push_back({lab[0], lab[1], lab[2]});
        }
        return result;
    }

    /// Three quarters of what a copy's mean lacks, at most 14 L*a*b*.
    Vec3d shift(const Look& look, Vec2f at) const
    {
        const Vec3d wanted = (mean_of(look) - mean_of(copy(at))) * 0.75;
        return wanted * std::min(1.0, 14 / std::max(length(wanted), 1e-9));
    }

    /// Mean squared difference of a value from a place's copy, in steps of a sixteenth L*a*b*, where the square of what the mean
    /// lacks gives way to that of what the shift leaves and a third of the squared shift as its price.
    double distance_of(const Look& look, Vec2f at) const
    {
        const Look own = copy(at);
        const Vec3d by = shift(look, at);
        const Vec3d gap = mean_of(look) - mean_of(own);
        const auto stepped = [](Vec3f v) {
            return Vec3d{std::round(16.0 * v.x), std::round(16.0 * v.y), std::round(16.0 * v.z)};
        };
        double sum = 0;
        for (std::size_t i = 0; i < look.size(); ++i)
        {
            const Vec3d away = (stepped(look[i]) - stepped(own[i])) * (1.0 / 16);
            sum += dot(away, away);
        }
        const double left = sum / static_cast<double>(look.size()) - dot(gap, gap) + dot(gap - by, gap - by);
        return std::max(0.0, left + dot(by, by) / 3) / 3;
    }

    double squared_distance(const float* features, std::size_t key) const
    {
        double sum = 0;
        for (std::size_t f = 0; f < picture_.feature_count(); ++f)
            sum += std::pow(double{features[f]} - double{picture_.key_features()[key * picture_.feature_count() + f]}, 2);
        return sum;
    }

    /// Completeness, 1 on average, times the price of crowding.
    Numbers key_weights(const std::vector<float>& features, const Numbers& crowding) const
    {
        Numbers weights;
        double mean = 0;
        for (std::size_t k = 0; k < picture_.key_count(); ++k)
        {
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t at = 0; at < features.size(); at += picture_.feature_count())
                least = std::min(least, squared_distance(&features[at], k));
            weights.push_back(1 / (options_.search.completeness * static_cast<double>(picture_.values_per_patch()) + least));
            mean += weights.back() / static_cast<double>(picture_.key_count());
        }
        for (std::size_t k = 0; k < weights.size(); ++k)
            weights[k] *= crowding[k] / mean;
        return weights;
    }

    /// How much a hundredth of the picture is used, in times the mean.
    double use_around(Vec2f key, const std::vector<Match>& matches) const
    {
        const int width = picture_.lab().width;
        const int height = picture_.lab().height;
        const auto half = static_cast<double>(std::lround(std::sqrt(0.01 * width * height) / 2));
        const Vec2d low{std::max(0.0, key.x - half), std::max(0.0, key.y - half)};
        const Vec2d high{std::min<double>(width, key.x + half), std::min<double>(height, key.y + half)};
        double used = 0;
        for (const Match& match : matches)
        {
            const Vec2d pixel{std::floor(match.at.x), std::floor(match.at.y)};
            used += pixel.x >= low.x && pixel.x < high.x && pixel.y >= low.y && pixel.y < high.y;
        }
        const Vec2d size = high - low;
        return used / static_cast<double>(matches.size()) * width * height / (size.x * size.y);
    }

    /// The best of each eighth of the keys by features, by squares of two strokes; of these the best by all values, with its
    /// price.
    Vec2f best_key(std::size_t patch, const float* features, const Searched& searched, const std::vector<Match>& before) const
    {
        std::array<double, 8> least;
        std::array<std::size_t, 8> best{};
        least.fill(std::numeric_limits<double>::infinity());
        for (std::size_t k = 0; k < picture_.key_count(); ++k)
        {
            const double distance = squared_distance(features, k) / static_cast<double>(picture_.values_per_patch());
            const double sum = searched.weights[k] * (distance - searched.unavoidable[patch] + double{options_.search.lift}) +
                               double{variety_.preference(patch, k)};
            const auto square = [&](float at) { return static_cast<std::uint32_t>(at / (2 * stroke_px_)); };
            const std::size_t of = noise::hash(square(picture_.key(k).x), square(picture_.key(k).y)) % 8;
            if (sum < least[of])
            {
                least[of] = sum;
                best[of] = k;
            }
        }
        for (std::size_t c = 0; c < 8; ++c)
            if (least[c] < std::numeric_limits<double>::infinity())
            {
                const Vec2f at = picture_.key(best[c]);
                least[c] = score(patch, std::max(0.0, distance_of(searched.looks[patch], at) - searched.unavoidable[patch]), at,
                                 searched.weights, before);
            }
        return picture_.key(best[static_cast<std::size_t>(std::ranges::min_element(least) - least.begin())]);
    }

    /// Per key, the variance around it as a share of itself and the median.
    Numbers motifs() const
    {
        const RasterF variance = local_variance(picture_.lab(), stroke_px_ / 2);
        Numbers result;
        for (std::size_t k = 0; k < picture_.key_count(); ++k)
            result.push_back(double{variance.at(static_cast<int>(picture_.key(k).x), static_cast<int>(picture_.key(k).y))});
        Numbers sorted = result;
        std::ranges::sort(sorted);
        for (double& v : result)
            v /= v + sorted[sorted.size() / 2];
        return result;
    }

    Match refined(const Look& look, Vec2f key) const
    {
        Match best{.at = key, .distance = static_cast<float>(distance_of(look, key))};
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
            {
                const Vec2f at = picture_.inside(key + Vec2f{static_cast<float>(x), static_cast<float>(y)});
                if (const auto away = static_cast<float>(distance_of(look, at)); away < best.distance)
                    best = {.at = at, .distance = away};
            }
        return best;
    }

    double score(std::size_t patch, double distance, Vec2f at, const Numbers& weights, const std::vector<Match>& uses) const
    {
        const std::size_t key = picture_.key_near(at);
        const double cost = weights[key] * (distance + double{options_.search.lift}) + double{variety_.preference(patch, key)};
        if (uses.empty())
            return cost;
        const NearbyUses::Copies found = copies(patch, at, uses);
        return cost + options_.search.repeat_cost * motifs_[key] * std::min(found.around, 1.0F) +
               options_.search.weave_cost * (1 - motifs_[key]) * std::min(found.beside, 1.0F);
    }

    /// The patch comes before all others over its center, in the order of their hashes.
    bool leads(std::uint32_t patch) const
    {
        const auto order = [&](std::uint32_t p) { return std::pair(noise::hash(options_.search.seed, p), p); };
        return std::ranges::none_of(patches_.covers(patches_[patch].texel),
                                    [&](std::uint32_t other) { return order(other) < order(patch); });
    }

    /// A place that continues what a patch over this one's center shows may differ more than the best one.
    Match continued(std::size_t patch, const Searched& searched, bool only_leaders) const
    {
        Match best = searched.uses[patch];
        double least = score(patch, searched, best.at, true);
        for (const std::uint32_t other : patches_.covers(patches_[patch].texel))
        {
            const Vec2f beyond = searched.uses[other].at + patches_.offset(other, patches_[patch].center);
            const Vec2f at = picture_.inside(beyond);
            if (other == patch || (only_leaders && !leads(other)) || length(at - beyond) >= 2)
                continue;
            if (const double found = score(patch, searched, at, false); found < least)
            {
                least = found;
                best = {.at = at, .distance = static_cast<float>(distance_of(searched.looks[patch], at))};
            }
        }
        best.shift = vec_cast<float>(shift(searched.looks[patch], best.at));
        return best;
    }

    /// In a window of deviation 0.35 sides that falls to 0 at the border, and by how well the patches fit.
    template <class Color>
    Mixed mixed(std::uint32_t texel, Vec3f position, const std::vector<Match>& matches, const Color& color) const
    {
        const Vec3f center = grid_.texels()[texel].position;
        const double side = picture_.side();
        const auto to_border = [side](double v)
        {
            const double t = std::clamp(2 - 4 * std::abs(v) / side, 0.0, 1.0);
            return t * t * (3 - 2 * t);
        };
        Mixed result;
        double total = 0;
        double most = -1;
        for (const std::uint32_t patch : patches_.covers(texel))
        {
            const Patch& lying = patches_[patch];
            const Vec2f away = (lying.place(position) - lying.place(center)) * static_cast<float>(1 / grid_.spacing_m());
            const Vec2f at = patches_.offset(patch, center) + away;
            const double weight = std::exp(-double{dot(at, at)} / (2 * std::pow(0.35 * side, 2))) * to_border(double{at.x}) *
                                  to_border(double{at.y}) * std::pow(double{matches[patch].distance} + 1, -0.6);
            const Vec2f place = matches[patch].at + at;
            const Vec3d own = vec_cast<double>(color(place));
            result.color += own * weight;
            result.shift += vec_cast<double>(matches[patch].shift) * weight;
            total += weight;
            if (weight > most)
            {
                most = weight;
                result.heaviest_color = own;
                result.place = place;
            }
        }
        result.color = result.color * (1 / total);
        result.shift = result.shift * (1 / total);
        return result;
    }

    const Task& task_;
    LevelOptions options_;
    const SurfaceGrid& grid_;
    const Patches& patches_;
    const StylePicture& picture_;
    double stroke_px_;
    Variety variety_;
    Numbers motifs_;
};

}  // namespace plain
