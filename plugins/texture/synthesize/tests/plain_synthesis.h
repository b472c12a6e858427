#pragma once

#include "plain_picture.h"
#include "search.h"
#include "synthesis.h"

#include <fresco/images/filters.h>
#include <fresco/images/lab.h>
#include <fresco/numerics/noise.h>
#include <fresco/testing.h>
#include <fresco/texturing/texel_faces.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

/// \file One level of a synthesis on a flat wall as its description says it: slow, on one thread, in double precision. Random
/// preferences and noise are those of the code under test.

namespace plain
{

struct Found
{
    Vec2d at;
    double distance = 0;
    Vec3d shift{};
};

/// The mean color of a point, and the patch that counts most in it.
struct Mixed
{
    Vec3d color;
    Vec3d heaviest_color;
    Covering heaviest{};
    Vec3d shift;  ///< Shift of the mean.
};

/// Inputs of a search.
struct Searched
{
    std::vector<Found> found;
    std::vector<Numbers> looks;  ///< Per patch, what is looked for.
    Numbers weights;             ///< Per key.
    std::vector<Found> uses;     ///< Uses that the last pass charged for.
};

class PlainLevel
{
  public:
    PlainLevel(const Task& task, const Level& level, const LevelOptions& options, double scale)
        : task_(task), level_(level), options_(options), wall_(task.surface, level.grid(), level.patches()),
          picture_(task.picture, scale, options.side),
          variety_(level.patches(), level.grid(), level.picture(), options.search.stroke_px, options.search.variety,
                   options.search.seed, testing::TestRun(1)),
          motifs_(motifs())
    {
    }

    const Picture& picture() const { return picture_; }

    std::vector<Vec3d> start() const
    {
        std::vector<Vec3d> result;
        for (std::size_t t = 0; t < level_.grid().texels().size(); ++t)
        {
            const Vec2d uv = wall_.texcoord(t);
            const Vec3f rgb = task_.start(wall_.chart(t), {static_cast<float>(uv.x), static_cast<float>(uv.y)},
                                          1 / level_.grid().sheet(wall_.chart(t)).cells_per_uv);
            result.push_back(vec_cast<double>(lab_from_rgb(rgb)));
        }
        return result;
    }

    /// The start with noise.
    std::vector<Vec3d> begin_alone() const
    {
        std::vector<Vec3d> result = start();
        for (std::size_t t = 0; t < result.size(); ++t)
        {
            const Vec3f at = level_.grid().texels()[t].position * static_cast<float>(1 / (4 * level_.grid().spacing_m()));
            const auto unrest = [&](std::uint32_t field)
            { return 2 * options_.unrest * static_cast<double>(smooth_noise(at, noise::hash(options_.search.seed, field))); };
            result[t] += {unrest(1), unrest(2) / 2, unrest(3) / 2};
        }
        return result;
    }

    /// Start from the patches of a coarser level, with this level's colors.
    std::vector<Vec3d> begin_after(const PlainLevel& coarser, const std::vector<Found>& matches) const
    {
        const double ratio = picture_.scale / coarser.picture_.scale;
        const auto color = [&](Vec2d at) {
            return color_of(picture_.lab, {(at.x + 0.5) * ratio - 0.5, (at.y + 0.5) * ratio - 0.5});
        };
        std::vector<Vec3d> result;
        for (std::size_t t = 0; t < level_.grid().texels().size(); ++t)
        {
            const std::size_t near = coarser.wall_.texel_near(wall_.chart(t), wall_.texcoord(t));
            const Mixed vote = coarser.mixed(near, level_.grid().texels()[t].position, matches, color);
            result.push_back(vote.color + vote.shift);
        }
        return result;
    }

    /// A round's search.
    Searched search(const std::vector<Vec3d>& colors, const Numbers& crowding, const std::vector<Found>& before) const
    {
        const std::vector<Vec3d> begun = start();
        std::vector<Vec3d> wanted;
        for (std::size_t t = 0; t < colors.size(); ++t)
            wanted.push_back(colors[t] * (1 - options_.faithfulness) + begun[t] * options_.faithfulness);
        Searched result;
        std::vector<Numbers> features;
        for (std::size_t p = 0; p < level_.patches().count(); ++p)
        {
            result.looks.push_back(wall_.sampled(p, wanted));
            features.push_back(picture_.projected(result.looks.back()));
        }
        result.weights = key_weights(features, crowding);
        for (std::size_t p = 0; p < features.size(); ++p)
            result.found.push_back(
                refined(result.looks[p], picture_.keys[best_key(p, features[p], result.looks[p], result.weights, before)]));
        for (int pass = 0; pass < 3; ++pass)
        {
            result.uses = result.found;
            for (std::size_t p = 0; p < features.size(); ++p)
            {
                Found& found = result.found[p] = continued(p, result.looks[p], result.uses, result.weights, pass == 0);
                found.shift = picture_.shift(result.looks[p], found.at);
            }
        }
        return result;
    }

    /// The prices after a round: they follow the square root of the use around a key in times 3 the mean, and never fall
    /// below 1.
    Numbers crowded(const Numbers& before, const std::vector<Found>& matches) const
    {
        Numbers result;
        for (std::size_t k = 0; k < before.size(); ++k)
            result.push_back(std::max(1.0, before[k] * std::sqrt(use_around(picture_.keys[k], matches) / 3)));
        return result;
    }

    /// Cost of a place of the picture for a patch; its own place, which nothing continues, costs more.
    double score(std::size_t patch, const Searched& searched, Vec2d at, bool is_own) const
    {
        const double distance = picture_.distance(searched.looks[patch], at);
        return score(patch, is_own ? as_own(distance) : distance, at, searched.weights, searched.uses);
    }

    /// Patches that show a place of the picture around a patch, other than the copy that it belongs to.
    struct Copies
    {
        double around = 0;
        double beside = 0;
    };
    Copies copies(std::size_t patch, Vec2d at, const std::vector<Found>& matches) const
    {
        if (matches.empty())
            return {};
        const double stroke_px = options_.search.stroke_px;
        const auto away = [](double a, double b, double unit) { return std::abs(std::floor(a / unit) - std::floor(b / unit)); };
        const auto is_from = [&](double v, double of)
        {
            const double cells = std::floor(v / (stroke_px / 2)) - std::floor(of / (stroke_px / 2) + 0.5);
            return cells == -1 || cells == 0;
        };
        double patches = 0;
        double around = 0;
        double beside = 0;
        for (std::size_t q = 0; q < matches.size(); ++q)
        {
            const double block_m = 2 * stroke_px * level_.grid().spacing_m();
            const Vec3d a = vec_cast<double>(level_.patches()[patch].center);
            const Vec3d b = vec_cast<double>(level_.patches()[q].center);
            const double blocks = std::max({away(a.x, b.x, block_m), away(a.y, b.y, block_m), away(a.z, b.z, block_m)});
            const auto& own = wall_.covers[level_.patches()[patch].texel];
            const bool is_own =
                std::any_of(own.begin(), own.end(),
                            [&](const Covering& cover)
                            {
                                const Vec2d next = matches[q].at + cover.offset - at;
                                return cover.patch == q && (q == patch || length(next) <= length(cover.offset) / 2);
                            });
            patches += static_cast<double>(wall_.covers[level_.patches()[q].texel].size());
            if (is_own || !is_from(matches[q].at.x, at.x) || !is_from(matches[q].at.y, at.y))
                continue;
            around += blocks <= 4 ? 1 : 0;
            beside += blocks <= 1 ? 1 : 0;
        }
        const double patches_per_copy =
            patches / static_cast<double>(matches.size()) * std::pow(stroke_px / level_.patches().side(), 2);
        return {around / patches_per_copy, beside / patches_per_copy};
    }

    /// The mean of the patches over each texel.
    std::vector<Vec3d> voted(const std::vector<Found>& matches) const
    {
        std::vector<Vec3d> result;
        const auto color = [&](Vec2d at) { return color_of(picture_.lab, at); };
        for (std::size_t t = 0; t < level_.grid().texels().size(); ++t)
        {
            const Mixed vote = mixed(t, level_.grid().texels()[t].position, matches, color);
            result.push_back(vote.color + vote.shift);
        }
        return result;
    }

    struct Texel
    {
        Vec3d rgb;
        Vec3d shift;  ///< Shift in RGB.
        Vec2d place;  ///< Place of the heaviest patch, in pixels of the style picture, pixel centers at +0.5.
    };

    /// The covered texels of a texture, by their numbers: the mean, with three quarters of the heaviest patch's luminance.
    std::map<std::size_t, Texel> texture(int size_px, const std::vector<Found>& matches) const
    {
        const Mesh& mesh = task_.surface.mesh;
        const auto faces = texturing::find_texel_faces(mesh, task_.surface.charts, size_px, testing::TestRun(1));
        // All charts have one scale. Pixels of the style picture along a texel:
        const double pixels = 1 / (task_.surface.uv_per_m[0] * size_px) / level_.grid().spacing_m() / picture_.scale;
        const auto shrunk = [&](int length) { return static_cast<int>(std::lround(length / std::max(pixels, 1.0))); };
        const Raster8 style = resized(task_.picture, shrunk(task_.picture.width), shrunk(task_.picture.height));
        const auto to = [&](const Raster8& picture, Vec2d at) {
            return Vec2d{(at.x + 0.5) * picture.width / picture_.lab.width, (at.y + 0.5) * picture.height / picture_.lab.height};
        };
        const auto color = [&](Vec2d at) { return color_of(style, to(style, at) - Vec2d{0.5, 0.5}) * (1 / 255.0); };
        std::map<std::size_t, Texel> result;
        for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
        {
            if (!faces.covered(texel))
                continue;
            const auto side = static_cast<std::size_t>(size_px);
            const Vec2d uv{(static_cast<double>(texel % side) + 0.5) / size_px,
                           1 - (static_cast<double>(texel / side) + 0.5) / size_px};
            const std::size_t near = wall_.texel_near(task_.surface.charts.of_face[faces.face[texel]], uv);
            const Mixed vote = mixed(near, texturing::texel_position(mesh, faces, texel), matches, color);
            const double lighter = 0.75 * dot(Vec3d{0.2126, 0.7152, 0.0722}, vote.heaviest_color - vote.color);
            const auto clamped = [lighter](double v) { return std::clamp(v + lighter, 0.0, 1.0); };
            const Vec3f copied = vec_cast<float>(Vec3d{clamped(vote.color.x), clamped(vote.color.y), clamped(vote.color.z)});
            const Vec3d rgb = vec_cast<double>(rgb_from_lab(lab_from_rgb(copied) + vec_cast<float>(vote.shift)));
            result[texel] = {rgb, rgb - vec_cast<double>(copied),
                             to(task_.picture, matches[vote.heaviest.patch].at + vote.heaviest.offset)};
        }
        return result;
    }

  private:
    /// Completeness, 1 on average, times the price of crowding.
    Numbers key_weights(const std::vector<Numbers>& queries, const Numbers& crowding) const
    {
        Numbers weights;
        for (std::size_t k = 0; k < picture_.keys.size(); ++k)
        {
            double least = std::numeric_limits<double>::infinity();
            for (const Numbers& query : queries)
                least = std::min(least, squared_distance(query, picture_.key_features[k]));
            weights.push_back(1 / (options_.search.completeness * static_cast<double>(picture_.mean.size()) + least));
        }
        double mean = 0;
        for (const double weight : weights)
            mean += weight / static_cast<double>(weights.size());
        for (std::size_t k = 0; k < weights.size(); ++k)
            weights[k] *= crowding[k] / mean;
        return weights;
    }

    /// How much a hundredth of the picture is used, in times the mean.
    double use_around(Vec2d key, const std::vector<Found>& matches) const
    {
        const int width = picture_.lab.width;
        const int height = picture_.lab.height;
        const auto half = static_cast<double>(std::lround(std::sqrt(0.01 * width * height) / 2));
        const Vec2d low{std::max(0.0, key.x - half), std::max(0.0, key.y - half)};
        const Vec2d high{std::min<double>(width, key.x + half), std::min<double>(height, key.y + half)};
        double used = 0;
        for (const Found& match : matches)
        {
            const Vec2d pixel{std::floor(match.at.x), std::floor(match.at.y)};
            used += pixel.x >= low.x && pixel.x < high.x && pixel.y >= low.y && pixel.y < high.y;
        }
        const Vec2d size = high - low;
        return used / static_cast<double>(matches.size()) * width * height / (size.x * size.y);
    }

    /// The best of each eighth of the keys by features, by squares of two strokes; of these the best by all values, with its
    /// price.
    std::size_t best_key(std::size_t patch, const Numbers& features, const Numbers& look, const Numbers& weights,
                         const std::vector<Found>& before) const
    {
        const double infinity = std::numeric_limits<double>::infinity();
        std::array<double, 8> least;
        std::array<std::size_t, 8> best{};
        least.fill(infinity);
        for (std::size_t k = 0; k < weights.size(); ++k)
        {
            const double distance =
                squared_distance(features, picture_.key_features[k]) / static_cast<double>(picture_.mean.size());
            const double sum =
                weights[k] * (distance + options_.search.lift) + static_cast<double>(variety_.preference(patch, k));
            const auto square = [&](double at) { return static_cast<std::uint32_t>(at / (2 * options_.search.stroke_px)); };
            const std::size_t of = noise::hash(square(picture_.keys[k].x), square(picture_.keys[k].y)) % 8;
            if (sum < least[of])
            {
                least[of] = sum;
                best[of] = k;
            }
        }
        for (std::size_t c = 0; c < 8; ++c)
            if (least[c] < infinity)
            {
                const Vec2d at = picture_.keys[best[c]];
                least[c] = score(patch, picture_.distance(look, at), at, weights, before);
            }
        return best[static_cast<std::size_t>(std::min_element(least.begin(), least.end()) - least.begin())];
    }

    double repeating(std::size_t patch, Vec2d at, const std::vector<Found>& matches) const
    {
        const double motif = motifs_[picture_.key_near(at)];
        const Copies found = copies(patch, at, matches);
        return options_.search.repeat_cost * motif * std::min(found.around, 1.0) +
               options_.search.weave_cost * (1 - motif) * std::min(found.beside, 1.0);
    }

    /// Per key, the variance around it as a share of itself and the median.
    Numbers motifs() const
    {
        const RasterF variance = local_variance(picture_.lab, options_.search.stroke_px / 2);
        Numbers result;
        for (const Vec2d key : picture_.keys)
            result.push_back(static_cast<double>(variance.at(static_cast<int>(key.x), static_cast<int>(key.y))));
        Numbers sorted = result;
        std::sort(sorted.begin(), sorted.end());
        for (double& v : result)
            v /= v + sorted[sorted.size() / 2];
        return result;
    }

    Found refined(const Numbers& look, Vec2d key) const
    {
        Found best{key, picture_.distance(look, key)};
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
            {
                const Vec2d at = picture_.inside(key + Vec2d{static_cast<double>(x), static_cast<double>(y)});
                if (const double away = picture_.distance(look, at); away < best.distance)
                    best = {at, away};
            }
        return best;
    }

    double score(std::size_t patch, double distance, Vec2d at, const Numbers& weights, const std::vector<Found>& uses) const
    {
        const std::size_t key = picture_.key_near(at);
        return weights[key] * (distance + options_.search.lift) + static_cast<double>(variety_.preference(patch, key)) +
               repeating(patch, at, uses);
    }

    double as_own(double distance) const { return 2 * (distance + 15 + options_.search.lift) - options_.search.lift; }

    /// The patch comes before all others over its center, in the order of their hashes.
    bool leads(std::size_t patch) const
    {
        const auto order = [&](std::size_t p)
        { return std::pair(noise::hash(options_.search.seed, static_cast<std::uint32_t>(p)), p); };
        const auto& covers = wall_.covers[level_.patches()[patch].texel];
        return std::none_of(covers.begin(), covers.end(),
                            [&](const Covering& cover) { return order(cover.patch) < order(patch); });
    }

    /// A place that continues what a patch over this one's center shows may differ more than the best one.
    Found continued(std::size_t patch, const Numbers& look, const std::vector<Found>& matches, const Numbers& weights,
                    bool only_leaders) const
    {
        Found best = matches[patch];
        double least = score(patch, as_own(best.distance), best.at, weights, matches);
        for (const Covering& cover : wall_.covers[level_.patches()[patch].texel])
        {
            if (only_leaders && !leads(cover.patch))
                continue;
            const Vec2d beyond = matches[cover.patch].at + cover.offset;
            const Vec2d at = picture_.inside(beyond);
            if (length(at - beyond) >= 2)
                continue;
            const double away = picture_.distance(look, at);
            if (const double found = score(patch, away, at, weights, matches); cover.patch != patch && found < least)
            {
                least = found;
                best = {at, away};
            }
        }
        return best;
    }

    /// In a window of deviation 0.35 sides that falls to 0 at the border, and by how well the patches fit.
    template <class Color>
    Mixed mixed(std::size_t texel, Vec3f position, const std::vector<Found>& matches, const Color& color) const
    {
        const Vec3d away = vec_cast<double>(position) - vec_cast<double>(level_.grid().texels()[texel].position);
        const double side = picture_.side;
        const auto to_border = [side](double v)
        {
            const double t = std::clamp(2 - 4 * std::abs(v) / side, 0.0, 1.0);
            return t * t * (3 - 2 * t);
        };
        Vec3d sum;
        Vec3d shifts;
        Mixed result;
        double total = 0;
        double most = -1;
        for (const Covering& cover : wall_.covers[texel])
        {
            const Vec2d at = cover.offset + wall_.on_patch(cover.patch, away);
            const double weight = std::exp(-dot(at, at) / (2 * std::pow(0.35 * side, 2))) * to_border(at.x) * to_border(at.y) *
                                  std::pow(matches[cover.patch].distance + 1, -0.6);
            const Vec3d own = color(matches[cover.patch].at + at);
            sum += own * weight;
            shifts += matches[cover.patch].shift * weight;
            total += weight;
            if (weight > most)
            {
                most = weight;
                result.heaviest_color = own;
                result.heaviest = {cover.patch, at};
            }
        }
        result.color = total > 0 ? sum * (1 / total) : result.heaviest_color;
        result.shift = total > 0 ? shifts * (1 / total) : most >= 0 ? matches[result.heaviest.patch].shift : Vec3d{};
        return result;
    }

    const Task& task_;
    const Level& level_;
    LevelOptions options_;
    Wall wall_;
    Picture picture_;
    Variety variety_;
    Numbers motifs_;
};

}  // namespace plain
