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

/// The samples of a texel, a vector per number and lane; those without weight fill up.
struct Weighted
{
    std::size_t vectors = 0;
    std::array<Floats, most_places / lanes> weight;
    std::array<std::array<Floats, most_places / lanes>, 3> rgb;
};

/// Makes all lanes the sum of all.
void add_lanes(Floats& v)
{
    Four low;
    Four high;
    std::memcpy(&low, &v, sizeof low);
    std::memcpy(&high, reinterpret_cast<const std::byte*>(&v) + sizeof low, sizeof high);
    low += high;
    v = Floats{} + ((low[0] + low[2]) + (low[1] + low[3]));
}

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
        for (std::size_t i = 0; i < samples.vectors; ++i)
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
        add_lanes(total);
        for (std::size_t c = 0; c < 3; ++c)
        {
            add_lanes(sum[c]);
            center[c] = sum[c] / total;
        }
    }
}

/// The least distance that at least half of the weight does not exceed.
float median_distance(const Weighted& samples, std::size_t count, const std::array<Floats, most_places / lanes>& distances)
{
    Floats total{};
    for (std::size_t i = 0; i < samples.vectors; ++i)
        total += samples.weight[i];
    add_lanes(total);
    float least = std::numeric_limits<float>::max();
    for (std::size_t s = 0; s < count; ++s)
    {
        const float limit = distances[s / lanes][s % lanes];
        if (limit >= least)
            continue;
        Floats within{};
        for (std::size_t i = 0; i < samples.vectors; ++i)
            within += distances[i] <= limit ? samples.weight[i] : Floats{};
        add_lanes(within);
        if (within[0] * 2 >= total[0])
            least = limit;
    }
    return least;
}

KeptSample kept_with(const TexelSample& sample, float weight_factor, Color gain)
{
    const float saturation = noise::smooth_step(saturates_from, 1, std::max({sample.rgb[0], sample.rgb[1], sample.rgb[2]}));
    const float of_white = std::max({1.0F, gain[0], gain[1], gain[2]});
    for (std::size_t c = 0; c < 3; ++c)
        gain[c] = sample.rgb[c] * (gain[c] + (of_white - gain[c]) * saturation);
    return {sample.weight * weight_factor * (1 + (saturated_weight - 1) * saturation), gain};
}

/// Puts a sample where it belongs. Returns the one that falls out at the end.
KeptSample put(KeptSample sample, std::span<KeptSample> places)
{
    bool is_in = false;
    for (KeptSample& place : places)
    {
        is_in = is_in || sample.heavier_than(place);
        const KeptSample before = place;
        place = is_in ? sample : before;
        sample = is_in ? before : sample;
    }
    return sample;
}

}  // namespace

FRESCO_WIDE_VECTORS std::vector<ExposedSample> exposed(std::span<const TexelSample> samples, float weight_factor,
                                                       const Gains* gains)
{
    std::vector<ExposedSample> result;
    result.reserve(samples.size());
    for (const TexelSample& sample : samples)
    {
        const KeptSample kept = gains != nullptr ? kept_with(sample, weight_factor, gain_at(*gains, sample.at))
                                                 : KeptSample(sample.weight * weight_factor, sample.rgb);
        if (!kept.empty())
            result.push_back({sample.texel, kept});
    }
    return result;
}

FRESCO_WIDE_VECTORS Blend blended(std::span<const KeptSample> samples, float nearest)
{
    // Samples heavier than the last place take part; if all are equally heavy, all do.
    const float threshold = samples.front().heavier_than(samples.back()) ? samples.back().weight() : 0;
    Weighted used;
    std::size_t count = 0;
    const auto put = [&](float weight, const Color& rgb)
    {
        used.weight[count / lanes][count % lanes] = weight;
        for (std::size_t c = 0; c < 3; ++c)
            used.rgb[c][count / lanes][count % lanes] = rgb[c];
    };
    for (const KeptSample& sample : samples)
        if (const float weight = sample.weight(); weight > threshold)
        {
            put(weight - threshold, sample.rgb());
            ++count;
        }
    Blend result;
    result.used = static_cast<int>(count);
    for (; count % lanes != 0; ++count)
        put(0, {});
    used.vectors = count / lanes;

    std::array<Floats, 3> center;
    geometric_median(used, center);
    std::array<Floats, most_places / lanes> distances;
    for (std::size_t i = 0; i < used.vectors; ++i)
        distance(used, i, center, distances[i]);
    const auto samples_count = static_cast<std::size_t>(result.used);
    const float limit = std::max(nearest, median_factor * median_distance(used, samples_count, distances));
    std::array<Floats, 3> sum{};
    Floats total{};
    for (std::size_t i = 0; i < used.vectors; ++i)
    {
        const Floats ratio = distances[i] * (1 / limit);
        Floats share = 1 - ratio * ratio;
        share = share > 0 ? share : Floats{};
        for (std::size_t lane = 0; lane < lanes; ++lane)
            result.rejected += share[lane] == 0 && used.weight[i][lane] > 0;
        const Floats weight = used.weight[i] * (share * share);
        total += weight;
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += weight * used.rgb[c][i];
    }
    add_lanes(total);
    for (std::size_t c = 0; c < 3; ++c)
    {
        add_lanes(sum[c]);
        result.rgb[c] = std::clamp(sum[c][0] / total[0], 0.0F, 1.0F);
    }
    return result;
}

std::uint32_t BestSamples::Arrays::make()
{
    if (count_ % per_page == 0)
        pages_.push_back(std::make_unique<KeptSample[]>(per_page * length_));
    return ++count_;
}

BestSamples::BestSamples(std::size_t texels, std::size_t places, std::size_t first)
    : first_(first), heavier_(places / 2), lighter_(places - places / 2), heavier_of_(texels, 0)
{
}

FRESCO_WIDE_VECTORS void BestSamples::add(std::span<const ExposedSample> samples)
{
    for (const ExposedSample& sample : samples)
    {
        std::uint32_t& number = heavier_of_[sample.texel - first_];
        if (number == 0)
        {
            number = heavier_.make();
            lighter_of_.push_back(0);
        }
        const std::uint32_t full = lighter_of_[number - 1];
        if (full != 0 && !sample.kept.heavier_than(lighter_[full].back()))
            continue;
        const std::span<KeptSample> heavier = heavier_[number];
        const KeptSample out = sample.kept.heavier_than(heavier.back()) ? put(sample.kept, heavier) : sample.kept;
        if (out.empty())
            continue;
        std::uint32_t& more = lighter_of_[number - 1];
        if (more == 0)
            more = lighter_.make();
        put(out, lighter_[more]);
    }
}

std::span<const KeptSample> BestSamples::of(std::size_t texel, std::span<KeptSample, most_places> out) const
{
    const std::uint32_t number = heavier_of_[texel - first_];
    if (number == 0)
        return {};
    const std::span<const KeptSample> heavier = heavier_[number];
    const auto end = std::ranges::copy(heavier, out.begin()).out;
    if (const std::uint32_t more = lighter_of_[number - 1]; more != 0)
        return {out.begin(), std::ranges::copy(lighter_[more], end).out};
    *end = {};  // The threshold.
    return {out.begin(), end + 1};
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
constexpr int survey_height = 240;
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
    return cell_colors(gather(map, links, weights.weight, PicturePyramid(view.picture), {side, side, true}), side);
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
    const Blender blend_cell = [&](std::span<const TexelSample> samples)
    {
        BestSamples best(1, places);
        for (const TexelSample& sample : samples)
            best.add(exposed(std::span(&sample, 1), 1, nullptr));
        std::array<KeptSample, most_places> kept;
        return blended(best.of(0, kept)).rgb;
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

Gathered gathered(const View& view, const RejectedPixels& rejected, float sharpness, const Gains& gains,
                  const TextureRules& rules)
{
    const PixelLinks links(view.map, view.camera);
    const auto weights = view_weights(view.map, links, view.camera, rejected, rules.size_px);
    Gathered result;
    result.pixels = static_cast<std::size_t>(
        std::count_if(view.map.valid.values.begin(), view.map.valid.values.end(), [](auto v) { return v != 0; }));
    result.edge_pixels = weights.edge_pixels;
    result.rejected_pixels = static_cast<std::size_t>(std::ranges::count(rejected, true));
    for (const auto& samples :
         gather(view.map, links, weights.weight, PicturePyramid(view.picture), {rules.size_px, rows_per_block, false}))
        result.samples.push_back(exposed(samples, sharpness, &gains));
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
                                               result.gains[view], rules);
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
                     std::array<KeptSample, most_places> kept;
                     for (std::size_t texel = first * rows; texel < last * rows; ++texel)
                     {
                         const auto samples = here.of(texel, kept);
                         if (samples.empty())
                             continue;
                         const Blend color = blended(samples, nearest);
                         result.seen.values[texel] = 1;
                         std::ranges::copy(color.rgb, &result.picture.values[3 * texel]);
                         blended_in_row[texel / rows] += static_cast<std::size_t>(color.used);
                         rejected_in_row[texel / rows] += static_cast<std::size_t>(color.rejected);
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
