#include "frames_texture.h"

#include "gather.h"

#include <fresco/error.h>
#include <fresco/images/push_pull.h>
#include <fresco/images/sharpness.h>
#include <fresco/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace fresco::from_frames
{
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
