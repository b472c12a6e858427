#include "frames_texture.h"

#include <fresco/error.h>
#include <fresco/images/filters.h>
#include <fresco/images/sharpness.h>
#include <fresco/numerics/noise.h>
#include <fresco/numerics/numerics.h>
#include <fresco/numerics/wide_vectors.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <utility>

namespace fresco::from_frames
{
namespace
{

constexpr float median_factor = 3;
constexpr float rounded = 0.02F;
constexpr int median_rounds = 6;
constexpr std::size_t most_places = BestSamples::most_places;
/// From here to 1 a channel is taken for more and more saturated.
constexpr float saturates_from = 0.9F;
constexpr float saturated_weight = 0.3F;

using Color = std::array<float, 3>;
using namespace numerics::wide_vectors;

/// The samples of as many texels as there are lanes; those without weight fill up.
struct Weighted
{
    std::size_t count = 0;
    std::array<Floats, most_places> weight;
    std::array<std::array<Floats, most_places>, 3> rgb;
};

/// Root mean square of the channels' differences, to five digits: by Newton's iterations, as vectors have no square roots.
void distance(const Weighted& samples, std::size_t i, const std::array<Floats, 3>& center, Floats& result)
{
    Floats sum{};
    for (std::size_t c = 0; c < 3; ++c)
        sum += (samples.rgb[c][i] - center[c]) * (samples.rgb[c][i] - center[c]);
    sum *= 1.0F / 3;
    Floats inverse_root = (Floats)(0x5f375a86 - ((Ints)sum >> 1));
    for (int round = 0; round < 2; ++round)
        inverse_root *= 1.5F - 0.5F * sum * inverse_root * inverse_root;
    result = sum * inverse_root;
}

/// The color with the least weighted sum of distances to the samples (Weiszfeld 1937), distances below `rounded` being
/// flattened: unlike the nearest sample, it changes steadily where weights do.
void geometric_median(const Weighted& samples, std::array<Floats, 3>& center)
{
    for (int round = 0; round <= median_rounds; ++round)
    {
        std::array<Floats, 3> sum{};
        Floats total{};
        for (std::size_t i = 0; i < samples.count; ++i)
        {
            Floats weight = samples.weight[i];
            if (round > 0)
            {
                Floats apart;
                distance(samples, i, center, apart);
                weight /= rounded + apart;
            }
            total += weight;
            for (std::size_t c = 0; c < 3; ++c)
                sum[c] += weight * samples.rgb[c][i];
        }
        for (std::size_t c = 0; c < 3; ++c)
            center[c] = sum[c] / total;
    }
}

/// The least distance that at least half of the weight does not exceed.
void median_distance(const Weighted& samples, const std::array<Floats, most_places>& distances, Floats& least)
{
    Floats half{};
    for (std::size_t i = 0; i < samples.count; ++i)
        half += samples.weight[i] * 0.5F;
    least = Floats{} + std::numeric_limits<float>::max();
    for (std::size_t s = 0; s < samples.count; ++s)
    {
        Floats within{};
        for (std::size_t i = 0; i < samples.count; ++i)
            within += distances[i] <= distances[s] ? samples.weight[i] : Floats{};
        least = (within >= half) & (distances[s] < least) ? distances[s] : least;
    }
}

}  // namespace

KeptSample exposed(float weight, Four rgb, Four gain)
{
    const float brightest = std::max({rgb[0], rgb[1], rgb[2]});
    if (brightest > saturates_from)
    {
        const float saturation = noise::smooth_step(saturates_from, 1, brightest);
        gain += (std::max({1.0F, gain[0], gain[1], gain[2]}) - gain) * saturation;
        weight *= 1 + (saturated_weight - 1) * saturation;
    }
    return {weight, rgb * gain};
}

FRESCO_WIDE_VECTORS std::array<Blend, lanes> blended(const TexelsSamples& texels, float nearest)
{
    std::array<Blend, lanes> result;
    Weighted used;
    for (const auto& samples : texels)
        used.count = std::max(used.count, samples.size());
    for (std::size_t i = 0; i < used.count; ++i)
        used.weight[i] = used.rgb[0][i] = used.rgb[1][i] = used.rgb[2][i] = Floats{};
    for (std::size_t lane = 0; lane < lanes; ++lane)
    {
        if (texels[lane].empty())
            continue;
        // Samples heavier than the last place take part; if all are equally heavy, all do.
        const KeptSample& last = texels[lane].back();
        const float threshold = texels[lane].front().heavier_than(last) ? last.weight() : 0;
        std::size_t count = 0;
        for (const KeptSample& sample : texels[lane])
            if (const float weight = sample.weight(); weight > threshold)
            {
                used.weight[count][lane] = weight - threshold;
                const Color rgb = sample.rgb();
                for (std::size_t c = 0; c < 3; ++c)
                    used.rgb[c][count][lane] = rgb[c];
                ++count;
            }
        result[lane].used = static_cast<int>(count);
    }
    std::array<Floats, 3> center;
    geometric_median(used, center);
    std::array<Floats, most_places> distances;
    for (std::size_t i = 0; i < used.count; ++i)
        distance(used, i, center, distances[i]);
    Floats limit;
    median_distance(used, distances, limit);
    limit *= median_factor;
    limit = limit > nearest ? limit : Floats{} + nearest;
    std::array<Floats, 3> sum{};
    Floats total{};
    Ints rejected{};
    for (std::size_t i = 0; i < used.count; ++i)
    {
        const Floats ratio = distances[i] / limit;
        Floats share = 1 - ratio * ratio;
        share = share > 0 ? share : Floats{};
        rejected -= (share == 0) & (used.weight[i] > 0);
        const Floats weight = used.weight[i] * (share * share);
        total += weight;
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += weight * used.rgb[c][i];
    }
    for (std::size_t lane = 0; lane < lanes; ++lane)
    {
        result[lane].rejected = rejected[lane];
        for (std::size_t c = 0; c < 3; ++c)
            result[lane].rgb[c] = std::clamp(sum[c][lane] / total[lane], 0.0F, 1.0F);
    }
    return result;
}

Blend blended(std::span<const KeptSample> samples, float nearest)
{
    return blended(TexelsSamples{samples}, nearest)[0];
}

std::uint32_t BestSamples::Arrays::make()
{
    if (!free_.empty())
    {
        const std::uint32_t number = free_.back();
        free_.pop_back();
        return number;
    }
    if (count_ % per_page == 0)
        pages_.push_back(std::make_unique<KeptSample[]>(per_page * length_));
    return count_++;
}

void BestSamples::Arrays::give_back(std::uint32_t number)
{
    std::ranges::fill((*this)[number], KeptSample());
    free_.push_back(number);
}

BestSamples::BestSamples(std::size_t texels, std::size_t places, std::size_t first)
    : first_(first), places_(places), half_(places / 2 + 1), all_(places), texels_(texels)
{
}

void BestSamples::add(std::span<const ExposedSample> samples)
{
    const std::size_t half = places_ / 2;
    for (const ExposedSample& sample : samples)
    {
        Texel& texel = texels_[sample.texel - first_];
        if (sample.kept.order() <= texel.lightest)
            continue;
        if (texel.count == 0)
            texel.array = half_.make();
        else if (texel.count == half)
        {
            const std::uint32_t larger = all_.make();
            std::ranges::copy(half_[texel.array].first(half), all_[larger].begin());
            half_.give_back(texel.array);
            texel.array = larger;
        }
        const std::span<KeptSample> places = (texel.count < half ? half_ : all_)[texel.array];
        std::size_t at = std::min<std::size_t>(texel.count, places_ - 1);
        for (; at > 0 && sample.kept.heavier_than(places[at - 1]); --at)
            places[at] = places[at - 1];
        places[at] = sample.kept;
        texel.count = static_cast<std::uint16_t>(std::min<std::size_t>(texel.count + 1U, places_));
        if (texel.count == places_)
            texel.lightest = places.back().order();
    }
}

std::span<const KeptSample> BestSamples::of(std::size_t texel) const
{
    const Texel& found = texels_[texel - first_];
    if (found.count == 0)
        return {};
    return (found.count <= places_ / 2 ? half_ : all_)[found.array].first(std::min<std::size_t>(found.count + 1U, places_));
}

namespace
{

/// The samples of so many rows fit into a processor's cache …
constexpr int rows_per_block = 8;
/// … where those of so many views are added to them.
constexpr std::size_t views_at_once = 8;
/// Cells a side of the texture that exposures are compared on.
constexpr int exposure_cells = 512;
/// Rows of the maps that suffice for it.
constexpr int survey_height = 180;
/// As frames.sharpest measures it by default.
constexpr int sharpness_width = 320;
constexpr int sharpness_height = 240;
constexpr std::size_t sharpness_reach = 4;
constexpr double least_sharpness_factor = 0.1;
constexpr double most_sharpness_factor = 4;
/// Samples this many times as far from the blend as half of all samples may be outliers.
constexpr float outlier_factor = 4;

/// Results of the first pass over the views.
struct Survey
{
    std::vector<std::vector<CellColor>> colors;  ///< Per view.
    std::vector<double> sharpness;
    std::vector<std::string> sequences;
    std::vector<RejectedPixels> rejected;
    int side = 0;  ///< Side of the colors' texture, in cells.
};

template <class T>
Raster<T> every_nth(const Raster<T>& raster, int n)
{
    Raster<T> result(raster.width / n, raster.height / n, raster.channels);
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
            std::copy_n(&raster.at(n * x, n * y), raster.channels, &result.at(x, y));
    return result;
}

/// The cells that a view shows of the coarse texture. Cells are wider than pixels, so that every n-th pixel of a large map
/// suffices; places are then off by less than a cell.
std::vector<CellColor> surveyed(const View& view, const RejectedPixels& rejected, int side, const TextureRules& rules)
{
    const int n = std::max(1, view.map.valid.height / survey_height);
    const UvMap map = n == 1 ? view.map
                             : UvMap{every_nth(view.map.uv, n), every_nth(view.map.depth, n), every_nth(view.map.cosine, n),
                                     every_nth(view.map.valid, n)};
    RejectedPixels rejected_of_map;
    for (int y = 0; !rejected.empty() && y < map.valid.height; ++y)
        for (int x = 0; x < map.valid.width; ++x)
            rejected_of_map.push_back(rejected[view.map.valid.index(n * x, n * y)]);
    const PixelLinks links(map, view.camera);
    auto weights = view_weights(map, links, view.camera, rejected_of_map, rules.size_px);
    for (std::size_t pixel = 0; pixel < weights.trust.values.size(); ++pixel)
        if (weights.trust.values[pixel] == 0)
            weights.weight.values[pixel] = 0;
    const PicturePyramid picture(view.picture);
    std::vector<TexelSample> colored;
    gather(map, links, weights.weight, {side, side, true},
           [&](std::size_t, std::span<const DrawnSample> samples)
           {
               for (const DrawnSample& sample : samples)
               {
                   const Four rgb = picture.at(sample.at, sample.covered);
                   colored.push_back({sample.texel, sample.weight, {rgb[0], rgb[1], rgb[2]}, sample.at});
               }
           });
    return cell_colors(colored, side);
}

Survey survey(std::size_t count, const ViewReader& read, const TextureRules& rules, Progress& progress)
{
    Survey result;
    result.colors.resize(count);
    result.sharpness.resize(count);
    result.sequences.resize(count);
    result.rejected.resize(count);
    result.side = std::min(rules.size_px, exposure_cells);
    const auto batch = static_cast<std::size_t>(std::max(1, progress.threads()));
    for (std::size_t begin = 0; begin < count; begin += batch)
    {
        const std::size_t end = std::min(begin + batch, count);
        parallel_items(end - begin, 1, progress,
                       [&](std::size_t item)
                       {
                           const std::size_t i = begin + item;
                           const View view = read(i, true);
                           result.sequences[i] = view.sequence;
                           result.sharpness[i] = sharpness(view.picture, sharpness_width, sharpness_height);
                           result.rejected[i] = rejected_pixels(view.map, view.measured);
                           result.colors[i] = surveyed(view, result.rejected[i], result.side, rules);
                       });
        progress.progress(static_cast<double>(end), static_cast<double>(2 * count), "views");
    }
    return result;
}

/// Solves the gains and keeps them where they lower the local error of the blend: in each group of views that see each other,
/// all or none. Returns how far apart colors of one point may lie, which the blend must not take for outliers.
float solve_exposure(Survey& found, const TextureRules& rules, FramesTexture& result, const Progress& progress)
{
    for (std::size_t v = 0; v < found.colors.size(); ++v)
        for (CellColor& color : found.colors[v])
            color.weight *= static_cast<float>(result.sharpness[v]);
    const auto places = static_cast<std::size_t>(rules.views_count) + 1;
    std::vector<KeptSample> best;
    const Blender blend_cell = [&](std::span<const TexelSample> samples)
    {
        best.clear();
        for (const TexelSample& sample : samples)
            best.emplace_back(sample.weight, Four{sample.rgb[0], sample.rgb[1], sample.rgb[2]});
        std::ranges::stable_sort(best, [](const KeptSample& a, const KeptSample& b) { return a.heavier_than(b); });
        best.resize(places);
        return blended(best).rgb;
    };
    const auto quality = [&](const std::vector<Gains>& gains)
    { return blend_quality(found.colors, found.side, gains, blend_cell); };
    BlendQuality used = quality(result.gains);
    result.error_without_gains = used.total_error;
    const auto cells = static_cast<std::size_t>(found.side) * static_cast<std::size_t>(found.side);
    std::vector<Gains> gains = exposure_gains(found.colors, cells, progress);
    const BlendQuality with_gains = quality(gains);
    const auto groups = overlapping_groups(found.colors, cells);
    std::vector<double> gained(gains.size(), 0);
    for (std::size_t v = 0; v < gains.size(); ++v)
        gained[groups[v]] +=
            static_cast<double>(found.colors[v].size()) * (std::pow(used.error[v], 2) - std::pow(with_gains.error[v], 2));
    for (std::size_t v = 0; v < gains.size(); ++v)
        if (gained[groups[v]] > 0)
            result.gains[v] = std::move(gains[v]);
    used = quality(result.gains);
    result.error = used.total_error;
    return std::max(least_distance, outlier_factor * used.median_distance);
}

struct Gathered
{
    std::vector<std::vector<ExposedSample>> samples;  ///< Per block.
    std::size_t pixels = 0;
    std::size_t edge_pixels = 0;
    std::size_t rejected_pixels = 0;
};

/// The samples of a view that may be among the best ones of their texels, in the view's exposure.
FRESCO_WIDE_VECTORS std::vector<ExposedSample> all_exposed(std::span<const DrawnSample> samples, const PicturePyramid& picture,
                                                           float weight_factor, const Gains& gains, const BestSamples& best)
{
    std::vector<ExposedSample> result;
    result.reserve(samples.size());
    for (const DrawnSample& sample : samples)
        if (const float weight = sample.weight * weight_factor; best.has_room(sample.texel, weight))
            result.push_back({sample.texel, exposed(weight, picture.at(sample.at, sample.covered),
                                                    four_between(gains, sample.at[0], sample.at[1]))});
    return result;
}

Gathered gathered(const View& view, const RejectedPixels& rejected, float sharpness, const Gains& gains,
                  const TextureRules& rules, const std::vector<BestSamples>& best)
{
    const PixelLinks links(view.map, view.camera);
    const auto weights = view_weights(view.map, links, view.camera, rejected, rules.size_px);
    Gathered result;
    result.pixels = static_cast<std::size_t>(
        std::count_if(view.map.valid.values.begin(), view.map.valid.values.end(), [](auto v) { return v != 0; }));
    result.edge_pixels = weights.edge_pixels;
    result.rejected_pixels = static_cast<std::size_t>(std::ranges::count(rejected, true));
    const PicturePyramid picture(view.picture);
    gather(view.map, links, weights.weight, {rules.size_px, rows_per_block, false},
           [&](std::size_t block, std::span<const DrawnSample> samples)
           { result.samples.push_back(all_exposed(samples, picture, sharpness, gains, best[block])); });
    return result;
}

/// The second reading: every view's samples go to their texels.
void fill(std::vector<BestSamples>& best, FramesTexture& result, const ViewReader& read,
          const std::vector<RejectedPixels>& rejected, const TextureRules& rules, Progress& progress)
{
    const std::size_t count = result.gains.size();
    const auto batch = std::max(views_at_once, static_cast<std::size_t>(progress.threads()));
    for (std::size_t begin = 0; begin < count; begin += batch)
    {
        const std::size_t end = std::min(begin + batch, count);
        std::vector<Gathered> views(end - begin);
        parallel_items(views.size(), 1, progress,
                       [&](std::size_t i)
                       {
                           const std::size_t view = begin + i;
                           views[i] = gathered(read(view, false), rejected[view], static_cast<float>(result.sharpness[view]),
                                               result.gains[view], rules, best);
                       });
        parallel_items(best.size(), 1, progress,
                       [&](std::size_t block)
                       {
                           for (const Gathered& view : views)
                               best[block].add(view.samples[block]);
                       });
        for (const Gathered& view : views)
        {
            result.pixels += view.pixels;
            result.edge_pixels += view.edge_pixels;
            result.occluded_pixels += view.rejected_pixels;
        }
        progress.progress(static_cast<double>(count + end), static_cast<double>(2 * count), "views");
    }
}

void blend(const std::vector<BestSamples>& best, FramesTexture& result, float nearest, const Progress& progress)
{
    const int size = result.seen.width;
    const auto rows = static_cast<std::size_t>(size);
    std::vector<std::size_t> blended_in_row(rows);
    std::vector<std::size_t> rejected_in_row(rows);
    parallel_for(rows, rows_per_block, progress,
                 [&](std::size_t first, std::size_t last)
                 {
                     progress.check_canceled();
                     const BestSamples& here = best[first / rows_per_block];
                     std::array<std::size_t, lanes> blending;
                     TexelsSamples samples;
                     std::size_t count = 0;
                     for (std::size_t texel = first * rows; texel < last * rows; ++texel)
                     {
                         blending[count] = texel;
                         samples[count] = here.of(texel);
                         count += samples[count].empty() ? 0 : 1;
                         if (count < lanes && texel + 1 < last * rows)
                             continue;
                         const auto colors = blended(samples, nearest);
                         for (std::size_t i = 0; i < count; ++i)
                         {
                             result.seen.values[blending[i]] = 1;
                             std::ranges::copy(colors[i].rgb, &result.picture.values[3 * blending[i]]);
                             blended_in_row[blending[i] / rows] += static_cast<std::size_t>(colors[i].used);
                             rejected_in_row[blending[i] / rows] += static_cast<std::size_t>(colors[i].rejected);
                         }
                         count = 0;
                     }
                 });
    for (std::size_t row = 0; row < rows; ++row)
    {
        result.blended_samples += blended_in_row[row];
        result.rejected_samples += rejected_in_row[row];
    }
}

}  // namespace

std::vector<double> sharpness_factors(const std::vector<double>& sharpness, const std::vector<std::string>& sequences)
{
    std::vector<double> factors;
    for (std::size_t i = 0; i < sharpness.size(); ++i)
    {
        std::vector<double> around;
        for (std::size_t j = i - std::min(i, sharpness_reach); j < std::min(sharpness.size(), i + sharpness_reach + 1); ++j)
            if (sequences[j] == sequences[i])
                around.push_back(sharpness[j]);
        const double usual = numerics::median(std::move(around));
        const double ratio = usual > 0 ? sharpness[i] / usual : 1;
        factors.push_back(std::clamp(std::pow(ratio, 2), least_sharpness_factor, most_sharpness_factor));
    }
    return factors;
}

FramesTexture frames_texture(std::size_t count, const ViewReader& read, const TextureRules& rules, Progress& progress)
{
    FramesTexture result;
    result.gains.assign(count, no_gains());
    float nearest = 0;
    std::vector<RejectedPixels> rejected;
    {
        Survey found = survey(count, read, rules, progress);
        result.sharpness = sharpness_factors(found.sharpness, found.sequences);
        nearest = solve_exposure(found, rules, result, progress);
        rejected = std::move(found.rejected);
    }
    {
        const auto row = static_cast<std::size_t>(rules.size_px);
        std::vector<BestSamples> best;
        for (std::size_t first = 0; first < row; first += rows_per_block)
            best.emplace_back(std::min<std::size_t>(rows_per_block, row - first) * row,
                              static_cast<std::size_t>(rules.views_count) + 1, first * row);
        fill(best, result, read, rejected, rules, progress);
#ifdef __GLIBC__
        malloc_trim(0);  // The views' memory is free, but in small pieces that the picture does not fit into.
#endif
        result.picture = RasterF(rules.size_px, rules.size_px, 3);
        result.seen = Raster8(rules.size_px, rules.size_px);
        blend(best, result, nearest, progress);
    }
    if (result.blended_samples == 0)
        throw Error("no view shows a texel: wire uv maps of these frames, and use pictures with opaque parts");
    push_pull(result.picture, result.seen);
    return result;
}

}  // namespace fresco::from_frames
