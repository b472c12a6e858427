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

namespace fresco::from_frames
{
namespace
{

constexpr float packed_steps = 32767;
constexpr float least_limit = 0.15F;
constexpr float median_factor = 3;
constexpr float rounded = 0.02F;
constexpr int median_rounds = 6;
constexpr std::size_t most_places = 64;
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

Blend blended(std::span<const KeptSample> samples, const BlendRules& rules)
{
    // What is heavier than the last place takes part. Equally heavy samples all do.
    const float threshold = samples.front().heavier_than(samples.back()) ? samples.back().weight() : 0;
    std::array<Weighted, most_places> used_places;
    std::size_t count = 0;
    for (const KeptSample& sample : samples)
        if (const float weight = sample.weight(); weight > threshold)
            used_places[count++] = {weight - threshold, sample.rgb()};
    const std::span<const Weighted> used(used_places.data(), count);

    Blend result;
    result.used = static_cast<int>(count);
    Color center{};
    float limit = 0;
    if (rules.reject_outliers)
    {
        center = geometric_median(used);
        limit = std::max(least_limit, median_factor * median_distance(used, center));
    }
    Color sum{};
    float total = 0;
    for (const Weighted& sample : used)
    {
        float weight = sample.weight;
        if (rules.reject_outliers)
        {
            const float ratio = distance(sample.rgb, center) / limit;
            const float share = std::max(0.0F, 1 - ratio * ratio);
            result.rejected += share == 0;
            weight *= share * share;
        }
        total += weight;
        for (std::size_t c = 0; c < 3; ++c)
            sum[c] += weight * sample.rgb[c];
    }
    for (std::size_t c = 0; c < 3; ++c)
        result.rgb[c] = std::clamp(sum[c] / total, 0.0F, 1.0F);
    return result;
}

BestSamples::BestSamples(std::size_t texels, std::size_t places) : places_(places), kept_(texels * places) {}

void BestSamples::add(std::span<const TexelSample> samples, float weight_factor, const std::optional<Color>& gain)
{
    for (const TexelSample& sample : samples)
    {
        const KeptSample kept =
            gain ? exposed(sample, weight_factor, *gain) : KeptSample(sample.weight * weight_factor, sample.rgb);
        KeptSample* const first = kept_.data() + std::size_t{sample.texel} * places_;
        KeptSample* place = first + places_ - 1;
        if (!kept.heavier_than(*place))
            continue;
        for (; place != first && kept.heavier_than(*(place - 1)); --place)
            *place = *(place - 1);
        *place = kept;
    }
}

namespace
{

constexpr std::size_t most_cells = 4096;
constexpr float least_value = 0.04F;
constexpr float most_value = 0.97F;
constexpr double prior = 0.04;
constexpr double first_scale = 0.8;
constexpr double scale_factor = 0.7;
constexpr double last_scale = 0.1;
constexpr int most_rounds = 20;
constexpr double settled = 1e-5;
/// Cells between two looks at whether to stop.
constexpr std::size_t check_distance = 64;

struct Observation
{
    std::uint32_t view = 0;
    double weight = 0;
    Gain log_rgb{};
};

/// The observations of all cells that two views or more show, cell by cell.
struct ByCell
{
    std::vector<Observation> observations;
    std::vector<std::size_t> begins;  ///< Per cell, and the end.
};

ByCell by_cell(const std::vector<std::vector<CellColor>>& views, std::size_t cells)
{
    std::vector<std::size_t> begins(cells + 1, 0);
    for (const auto& view : views)
        for (const CellColor& color : view)
            ++begins[color.cell + 1];
    for (std::size_t i = 1; i <= cells; ++i)
        begins[i] += begins[i - 1];
    ByCell result;
    result.observations.resize(begins.back());
    auto next = begins;
    for (std::uint32_t v = 0; v < views.size(); ++v)
        for (const CellColor& color : views[v])
            result.observations[next[color.cell]++] = {v,
                                                       static_cast<double>(color.weight),
                                                       {static_cast<double>(color.log_rgb[0]),
                                                        static_cast<double>(color.log_rgb[1]),
                                                        static_cast<double>(color.log_rgb[2])}};
    result.begins = std::move(begins);
    return result;
}

/// Minimizes the sum over cells for given weights; `weights`: one per observation.
std::vector<Gain> least_squares(const ByCell& cells, std::span<const double> weights, std::size_t views, const Progress& progress)
{
    std::vector<double> matrix(views * views, 0.0);
    std::vector<double> right(views * 3);
    for (std::size_t v = 0; v < views; ++v)
        matrix[v * views + v] = prior;
    for (std::size_t cell = 0; cell + 1 < cells.begins.size(); ++cell)
    {
        if (cell % check_distance == 0)
            progress.check_canceled();
        const std::size_t begin = cells.begins[cell];
        const std::size_t end = cells.begins[cell + 1];
        double total = 0;
        Gain mean{};
        for (std::size_t i = begin; i < end; ++i)
        {
            total += weights[i];
            for (std::size_t c = 0; c < 3; ++c)
                mean[c] += weights[i] * cells.observations[i].log_rgb[c];
        }
        for (std::size_t i = begin; i < end; ++i)
        {
            const Observation& seen = cells.observations[i];
            double* const row = matrix.data() + seen.view * views;
            row[seen.view] += weights[i];
            // Views ascend within a cell: the lower triangle.
            for (std::size_t j = begin; j <= i; ++j)
                row[cells.observations[j].view] -= weights[i] * weights[j] / total;
            for (std::size_t c = 0; c < 3; ++c)
                right[3 * seen.view + c] -= weights[i] * (seen.log_rgb[c] - mean[c] / total);
        }
    }
    numerics::solve_symmetric(matrix, right, 3);
    std::vector<Gain> offsets;
    for (std::size_t v = 0; v < views; ++v)
        offsets.push_back({right[3 * v], right[3 * v + 1], right[3 * v + 2]});
    return offsets;
}

/// Weights from what `offsets` leave of the differences in each cell.
void reweigh(const ByCell& cells, const std::vector<Gain>& offsets, double scale, std::vector<double>& weights)
{
    for (std::size_t cell = 0; cell + 1 < cells.begins.size(); ++cell)
    {
        const auto corrected = [&](std::size_t i, std::size_t c)
        { return cells.observations[i].log_rgb[c] + offsets[cells.observations[i].view][c]; };
        double total = 0;
        Gain color{};
        for (std::size_t i = cells.begins[cell]; i < cells.begins[cell + 1]; ++i)
        {
            total += weights[i];
            for (std::size_t c = 0; c < 3; ++c)
                color[c] += weights[i] * corrected(i, c);
        }
        for (std::size_t i = cells.begins[cell]; i < cells.begins[cell + 1]; ++i)
        {
            double squares = 0;
            for (std::size_t c = 0; c < 3; ++c)
                squares += std::pow(corrected(i, c) - color[c] / total, 2) / 3;
            weights[i] = cells.observations[i].weight / std::pow(1 + squares / (scale * scale), 2);
        }
    }
}

double largest_change(const std::vector<Gain>& a, const std::vector<Gain>& b)
{
    double largest = 0;
    for (std::size_t v = 0; v < a.size(); ++v)
        for (std::size_t c = 0; c < 3; ++c)
            largest = std::max(largest, std::abs(a[v][c] - b[v][c]));
    return largest;
}

}  // namespace

std::vector<CellColor> cell_colors(const SampleBlocks& samples)
{
    std::vector<CellColor> result;
    for (const auto& block : samples)
        for (const TexelSample& sample : block)
        {
            const auto [least, most] = std::minmax_element(sample.rgb.begin(), sample.rgb.end());
            if (*least >= least_value && *most <= most_value)
                result.push_back(
                    {sample.texel, sample.weight, {std::log(sample.rgb[0]), std::log(sample.rgb[1]), std::log(sample.rgb[2])}});
        }
    if (result.size() > most_cells)
    {
        const auto by_hash = [](const CellColor& a, const CellColor& b) { return noise::hash(a.cell) < noise::hash(b.cell); };
        std::nth_element(result.begin(), result.begin() + most_cells, result.end(), by_hash);
        result.resize(most_cells);
    }
    std::sort(result.begin(), result.end(), [](const CellColor& a, const CellColor& b) { return a.cell < b.cell; });
    return result;
}

std::vector<Gain> exposure_gains(const std::vector<std::vector<CellColor>>& views, std::size_t cells, const Progress& progress)
{
    const ByCell observed = by_cell(views, cells);
    std::vector<double> weights;
    for (const Observation& seen : observed.observations)
        weights.push_back(seen.weight);
    std::vector<Gain> offsets(views.size());
    double scale = first_scale;
    for (int round = 0; round < most_rounds; ++round)
    {
        auto next = least_squares(observed, weights, views.size(), progress);
        const double change = largest_change(next, offsets);
        offsets = std::move(next);
        if (scale == last_scale && change < settled)
            break;
        reweigh(observed, offsets, scale, weights);
        scale = std::max(last_scale, scale * scale_factor);
    }
    for (Gain& gain : offsets)
        for (double& factor : gain)
            factor = std::exp(factor);
    return offsets;
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

/// Calls `visit(i)` for every view, some at a time.
void for_views(std::size_t begin, std::size_t end, const Progress& progress, const std::function<void(std::size_t)>& visit)
{
    parallel_for(end - begin, 1, progress.threads(),
                 [&](std::size_t first, std::size_t last)
                 {
                     progress.check_canceled();
                     for (std::size_t i = first; i < last; ++i)
                         visit(begin + i);
                 });
}

/// What the first reading of the views finds out.
struct Survey
{
    std::vector<std::vector<CellColor>> colors;  ///< Per view.
    std::vector<double> sharpness;
    std::vector<std::string> sequences;
    int cells = 0;  ///< A side.
};

Survey survey(std::size_t count, const ViewReader& read, const TextureRules& rules, Progress& progress)
{
    Survey result;
    result.colors.resize(count);
    result.sharpness.resize(count);
    result.sequences.resize(count);
    result.cells = std::min(rules.size_px, exposure_cells);
    const auto batch = static_cast<std::size_t>(std::max(1, progress.threads()));
    for (std::size_t begin = 0; begin < count; begin += batch)
    {
        const std::size_t end = std::min(begin + batch, count);
        for_views(begin, end, progress,
                  [&](std::size_t i)
                  {
                      const View view = read(i);
                      result.sequences[i] = view.sequence;
                      result.sharpness[i] = sharpness(view.picture, sharpness_width, sharpness_height);
                      if (!rules.solve_exposure)
                          return;
                      const PixelLinks links(view.map, view.camera);
                      const auto weights =
                          view_weights(view.map, links, view.camera, view.measured, rules.size_px, rules.weights);
                      result.colors[i] = cell_colors(gather(view.map, links, weights.trust, PicturePyramid(view.picture),
                                                            {result.cells, result.cells, true}));
                  });
        progress.progress(static_cast<double>(end), static_cast<double>(2 * count), "views");
    }
    return result;
}

struct Gathered
{
    SampleBlocks samples;
    std::size_t pixels = 0;
    std::size_t edge_pixels = 0;
    std::size_t rejected_pixels = 0;
};

Gathered gathered(const View& view, const TextureRules& rules)
{
    const PixelLinks links(view.map, view.camera);
    const auto weights = view_weights(view.map, links, view.camera, view.measured, rules.size_px, rules.weights);
    Gathered result;
    result.pixels = static_cast<std::size_t>(
        std::count_if(view.map.valid.values.begin(), view.map.valid.values.end(), [](auto v) { return v != 0; }));
    result.edge_pixels = weights.edge_pixels;
    result.rejected_pixels = weights.rejected_pixels;
    result.samples =
        gather(view.map, links, weights.weight, PicturePyramid(view.picture), {rules.size_px, rows_per_block, false});
    return result;
}

std::array<float, 3> narrowed(const Gain& gain)
{
    return {static_cast<float>(gain[0]), static_cast<float>(gain[1]), static_cast<float>(gain[2])};
}

/// The second reading: every view's samples go to their texels.
void fill(BestSamples& best, FramesTexture& result, const ViewReader& read, const TextureRules& rules, Progress& progress)
{
    const std::size_t count = result.gains.size();
    const auto batch = static_cast<std::size_t>(std::max(1, progress.threads()));
    for (std::size_t begin = 0; begin < count; begin += batch)
    {
        const std::size_t end = std::min(begin + batch, count);
        std::vector<Gathered> views(end - begin);
        for_views(begin, end, progress, [&](std::size_t i) { views[i - begin] = gathered(read(i), rules); });
        parallel_for(views.front().samples.size(), 1, progress.threads(),
                     [&](std::size_t first, std::size_t last)
                     {
                         for (std::size_t block = first; block < last; ++block)
                             for (std::size_t i = begin; i < end; ++i)
                                 best.add(views[i - begin].samples[block], static_cast<float>(result.sharpness[i]),
                                          rules.solve_exposure ? std::optional(narrowed(result.gains[i])) : std::nullopt);
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

void blend(const BestSamples& best, FramesTexture& result, const BlendRules& rules, const Progress& progress)
{
    const int size = result.seen.width;
    const auto rows = static_cast<std::size_t>(size);
    std::vector<std::size_t> blended_in_row(rows);
    std::vector<std::size_t> rejected_in_row(rows);
    parallel_for(rows, rows_per_block, progress.threads(),
                 [&](std::size_t first, std::size_t last)
                 {
                     progress.check_canceled();
                     for (std::size_t texel = first * rows; texel < last * rows; ++texel)
                     {
                         const auto samples = best.of(texel);
                         if (samples.front().empty())
                             continue;
                         const Blend color = blended(samples, rules);
                         result.seen.values[texel] = 1;
                         std::copy(color.rgb.begin(), color.rgb.end(),
                                   result.picture.values.begin() + static_cast<std::ptrdiff_t>(3 * texel));
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

std::vector<double> sharpness_factors(const std::vector<double>& sharpness, const std::vector<std::string>& sequences,
                                      double power)
{
    std::vector<double> factors;
    for (std::size_t i = 0; i < sharpness.size(); ++i)
    {
        std::vector<double> around;
        for (std::size_t j = i - std::min(i, sharpness_reach); j < std::min(sharpness.size(), i + sharpness_reach + 1); ++j)
            if (sequences[j] == sequences[i])
                around.push_back(sharpness[j]);
        const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
        std::nth_element(around.begin(), middle, around.end());
        const double ratio = *middle > 0 ? sharpness[i] / *middle : 1;
        factors.push_back(std::clamp(std::pow(ratio, power), least_sharpness_factor, most_sharpness_factor));
    }
    return factors;
}

FramesTexture frames_texture(std::size_t count, const ViewReader& read, const TextureRules& rules, Progress& progress)
{
    FramesTexture result;
    result.gains.assign(count, Gain{1, 1, 1});
    result.sharpness.assign(count, 1);
    if (rules.solve_exposure || rules.sharpness_power > 0)
    {
        const Survey found = survey(count, read, rules, progress);
        result.sharpness = sharpness_factors(found.sharpness, found.sequences, rules.sharpness_power);
        if (rules.solve_exposure)
            result.gains = exposure_gains(
                found.colors, static_cast<std::size_t>(found.cells) * static_cast<std::size_t>(found.cells), progress);
    }
    const auto texels = static_cast<std::size_t>(rules.size_px) * static_cast<std::size_t>(rules.size_px);
    result.picture = RasterF(rules.size_px, rules.size_px, 3);
    result.seen = Raster8(rules.size_px, rules.size_px);
    {
        BestSamples best(texels, static_cast<std::size_t>(rules.views_count) + 1);
        fill(best, result, read, rules, progress);
        blend(best, result, rules.blend, progress);
    }
    if (result.blended_samples == 0)
        throw Error("no view shows a texel: wire uv maps of these frames");
    push_pull(result.picture, result.seen);
    return result;
}

}  // namespace fresco::from_frames
