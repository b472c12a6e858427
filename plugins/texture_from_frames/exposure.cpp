#include "exposure.h"

#include <fresco/numerics/noise.h>
#include <fresco/numerics/solve_symmetric.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace fresco::from_frames
{
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

}  // namespace fresco::from_frames
