#include "frames_texture.h"

#include <fresco/error.h>
#include <fresco/images/filters.h>
#include <fresco/images/sharpness.h>
#include <fresco/numerics/noise.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <bit>
#include <cmath>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <utility>

namespace fresco::from_frames
{
namespace
{

constexpr float packed_steps = 32767;
constexpr float median_factor = 3;
constexpr float rounded = 0.02F;
constexpr int median_rounds = 6;
constexpr std::size_t most_places = BestSamples::most_places;
/// From here to 1 a channel is taken for more and more saturated.
constexpr float saturates_from = 0.9F;
constexpr float saturated_weight = 0.3F;

using Color = std::array<float, 3>;

struct Weighted
{
    float weight = 0;
    Color rgb{};
};

float distance(const Color& a, const Color& b)
{
    float sum = 0;
    for (std::size_t c = 0; c < 3; ++c)
        sum += (a[c] - b[c]) * (a[c] - b[c]);
    return std::sqrt(sum / 3);
}

/// The color with the least weighted sum of distances to the samples (Weiszfeld 1937), distances below `rounded` being
/// flattened: unlike the nearest sample, it changes steadily where weights do.
Color geometric_median(std::span<const Weighted> samples)
{
    Color center{};
    for (int round = 0; round <= median_rounds; ++round)
    {
        Color sum{};
        float total = 0;
        for (const Weighted& sample : samples)
        {
            const float weight = round == 0 ? sample.weight : sample.weight / (rounded + distance(sample.rgb, center));
            total += weight;
            for (std::size_t c = 0; c < 3; ++c)
                sum[c] += weight * sample.rgb[c];
        }
        for (std::size_t c = 0; c < 3; ++c)
            center[c] = sum[c] / total;
    }
    return center;
}

/// Half of the weight is at most so far from `center`.
float median_distance(std::span<const Weighted> samples, const Color& center)
{
    std::array<std::pair<float, float>, most_places> by_distance;
    float total = 0;
    for (std::size_t i = 0; i < samples.size(); ++i)
    {
        by_distance[i] = {distance(samples[i].rgb, center), samples[i].weight};
        total += samples[i].weight;
    }
    std::sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(samples.size()));
    float sum = 0;
    for (std::size_t i = 0; i < samples.size(); ++i)
        if ((sum += by_distance[i].second) * 2 >= total)
            return by_distance[i].first;
    return by_distance[samples.size() - 1].first;
}

KeptSample exposed(const TexelSample& sample, float weight_factor, Color gain)
{
    const float saturation = noise::smooth_step(saturates_from, 1, std::max({sample.rgb[0], sample.rgb[1], sample.rgb[2]}));
    const float of_white = std::max({1.0F, gain[0], gain[1], gain[2]});
    for (std::size_t c = 0; c < 3; ++c)
        gain[c] = sample.rgb[c] * (gain[c] + (of_white - gain[c]) * saturation);
    return {sample.weight * weight_factor * (1 + (saturated_weight - 1) * saturation), gain};
}

/// Moves the samples from `place` on by one place, to put in another. Returns what falls out at the end.
KeptSample put(KeptSample sample, std::span<KeptSample> places, std::span<KeptSample>::iterator place)
{
    for (; place != places.end(); ++place)
        std::swap(*place, sample);
    return sample;
}

}  // namespace

KeptSample::KeptSample(float weight, const std::array<float, 3>& rgb)
    : weight_(static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(weight) >> 16U))
{
    for (std::size_t c = 0; c < 3; ++c)
        rgb_[c] = static_cast<std::uint16_t>(std::clamp(rgb[c] * packed_steps + 0.5F, 0.0F, 65535.0F));
}

float KeptSample::weight() const
{
    return std::bit_cast<float>(std::uint32_t{weight_} << 16U);
}

std::array<float, 3> KeptSample::rgb() const
{
    return {static_cast<float>(rgb_[0]) / packed_steps, static_cast<float>(rgb_[1]) / packed_steps,
            static_cast<float>(rgb_[2]) / packed_steps};
}

Blend blended(std::span<const KeptSample> samples, float nearest)
{
    // Samples heavier than the last place take part; if all are equally heavy, all do.
    const float threshold = samples.front().heavier_than(samples.back()) ? samples.back().weight() : 0;
    std::array<Weighted, most_places> used_places;
    std::size_t count = 0;
    for (const KeptSample& sample : samples)
        if (const float weight = sample.weight(); weight > threshold)
            used_places[count++] = {weight - threshold, sample.rgb()};
    const std::span<const Weighted> used(used_places.data(), count);

    Blend result;
    result.used = static_cast<int>(count);
    const Color center = geometric_median(used);
    const float limit = std::max(nearest, median_factor * median_distance(used, center));
    Color sum{};
    float total = 0;
    for (const Weighted& sample : used)
    {
        const float ratio = distance(sample.rgb, center) / limit;
        const float share = std::max(0.0F, 1 - ratio * ratio);
        result.rejected += share == 0;
        const float weight = sample.weight * (share * share);
        total += weight;
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += weight * sample.rgb[c];
    }
    for (std::size_t c = 0; c < 3; ++c)
        result.rgb[c] = std::clamp(sum[c] / total, 0.0F, 1.0F);
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

void BestSamples::add(std::span<const TexelSample> samples, float weight_factor, const Gains* gains)
{
    for (const TexelSample& sample : samples)
    {
        const KeptSample kept = gains != nullptr ? exposed(sample, weight_factor, gain_at(*gains, sample.at))
                                                 : KeptSample(sample.weight * weight_factor, sample.rgb);
        if (kept.empty())
            continue;
        const auto place_in = [&](std::span<KeptSample> places)
        { return std::ranges::find_if(places, [&](const KeptSample& other) { return kept.heavier_than(other); }); };
        std::uint32_t& number = heavier_of_[sample.texel - first_];
        if (number == 0)
        {
            number = heavier_.make();
            lighter_of_.push_back(0);
        }
        const std::span<KeptSample> heavier = heavier_[number];
        const KeptSample out = put(kept, heavier, place_in(heavier));
        if (out.empty())
            continue;
        std::uint32_t& more = lighter_of_[number - 1];
        if (more == 0)
            more = lighter_.make();
        const std::span<KeptSample> lighter = lighter_[more];
        put(out, lighter, place_in(lighter));  // At the front if the sample lies among the heavier ones.
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

constexpr int rows_per_block = 32;
/// Cells a side of the texture that exposures are compared on.
constexpr int exposure_cells = 512;
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
                           const PixelLinks links(view.map, view.camera);
                           auto weights = view_weights(view.map, links, view.camera, result.rejected[i], rules.size_px);
                           for (std::size_t pixel = 0; pixel < weights.trust.values.size(); ++pixel)
                               if (weights.trust.values[pixel] == 0)
                                   weights.weight.values[pixel] = 0;
                           result.colors[i] = cell_colors(gather(view.map, links, weights.weight, PicturePyramid(view.picture),
                                                                 {result.side, result.side, true}),
                                                          result.side);
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
            best.add({&sample, 1}, 1, nullptr);
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
    SampleBlocks samples;
    std::size_t pixels = 0;
    std::size_t edge_pixels = 0;
    std::size_t rejected_pixels = 0;
};

Gathered gathered(const View& view, const RejectedPixels& rejected, const TextureRules& rules)
{
    const PixelLinks links(view.map, view.camera);
    const auto weights = view_weights(view.map, links, view.camera, rejected, rules.size_px);
    Gathered result;
    result.pixels = static_cast<std::size_t>(
        std::count_if(view.map.valid.values.begin(), view.map.valid.values.end(), [](auto v) { return v != 0; }));
    result.edge_pixels = weights.edge_pixels;
    result.rejected_pixels = static_cast<std::size_t>(std::ranges::count(rejected, true));
    result.samples =
        gather(view.map, links, weights.weight, PicturePyramid(view.picture), {rules.size_px, rows_per_block, false});
    return result;
}

/// The second reading: every view's samples go to their texels.
void fill(std::vector<BestSamples>& best, FramesTexture& result, const ViewReader& read,
          const std::vector<RejectedPixels>& rejected, const TextureRules& rules, Progress& progress)
{
    const std::size_t count = result.gains.size();
    const auto batch = static_cast<std::size_t>(std::max(1, progress.threads()));
    for (std::size_t begin = 0; begin < count; begin += batch)
    {
        const std::size_t end = std::min(begin + batch, count);
        std::vector<Gathered> views(end - begin);
        parallel_items(views.size(), 1, progress,
                       [&](std::size_t i) { views[i] = gathered(read(begin + i, false), rejected[begin + i], rules); });
        parallel_items(best.size(), 1, progress,
                       [&](std::size_t block)
                       {
                           for (std::size_t i = begin; i < end; ++i)
                               best[block].add(views[i - begin].samples[block], static_cast<float>(result.sharpness[i]),
                                               &result.gains[i]);
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
