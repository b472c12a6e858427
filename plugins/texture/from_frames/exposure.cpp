#include "exposure.h"

#include <fresco/numerics/bilinear.h>
#include <fresco/numerics/noise.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>
#include <fresco/texture.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace fresco::from_frames
{
namespace
{

constexpr int square_side = 8;
constexpr std::size_t most_cells = 4096;
constexpr float least_value = 0.04F;
constexpr float most_value = 0.97F;

constexpr int grid_columns = 12;
constexpr int grid_rows = 9;
constexpr std::size_t nodes = std::size_t{grid_columns} * grid_rows;
constexpr double number_prior = 0.005;
constexpr double grid_prior = 0.02;
constexpr double stiffness = 0.5;

/// Grids are fitted from this scale on, when the weights of what is out of place have gone.
constexpr double leveled_from = 0.2;
constexpr std::array<double, 8> scales{0.8, 0.55, 0.4, 0.28, 0.2, 0.14, 0.1, 0.1};
constexpr int steps_per_scale = 20;

std::uint32_t square_of(std::uint32_t cell, int side)
{
    const auto width = static_cast<std::uint32_t>(side);
    return cell / width / square_side * width + cell % width / square_side;
}

/// The nodes around a place in the picture, with their shares.
struct Taps
{
    std::array<std::size_t, 4> node{};
    std::array<float, 4> share{};
};

Taps taps_at(const std::array<float, 2>& at)
{
    const auto x = numerics::between<float>(at[0] * grid_columns - 0.5F, grid_columns);
    const auto y = numerics::between<float>(at[1] * grid_rows - 0.5F, grid_rows);
    const auto node = [](int column, int row) { return static_cast<std::size_t>(row * grid_columns + column); };
    return {{node(x.first, y.first), node(x.second, y.first), node(x.first, y.second), node(x.second, y.second)},
            {(1 - x.share) * (1 - y.share), x.share * (1 - y.share), (1 - x.share) * y.share, x.share * y.share}};
}

/// The observations of all cells, cell by cell, each in the order of the views.
struct ByCell
{
    struct Observation
    {
        std::uint32_t view = 0;
        const CellColor* color = nullptr;
    };
    std::vector<Observation> observations;
    std::vector<std::size_t> begins;  ///< Per cell, and the end.

    ByCell(const std::vector<std::vector<CellColor>>& views, std::size_t cells) : begins(cells + 1, 0)
    {
        for (const auto& view : views)
            for (const CellColor& color : view)
                ++begins[color.cell + 1];
        for (std::size_t i = 1; i <= cells; ++i)
            begins[i] += begins[i - 1];
        observations.resize(begins.back());
        auto next = begins;
        for (std::uint32_t v = 0; v < views.size(); ++v)
            for (const CellColor& color : views[v])
                observations[next[color.cell]++] = {v, &color};
    }

    /// `visit(begin, end)` for every cell that several views show.
    template <class Visit>
    void each_shared(const Visit& visit) const
    {
        for (std::size_t cell = 0; cell + 1 < begins.size(); ++cell)
            if (begins[cell + 1] - begins[cell] > 1)
                visit(begins[cell], begins[cell + 1]);
    }
};

/// The unknowns of one channel: per view a number, then a grid.
using Logs = std::vector<double>;
constexpr std::size_t per_view = 1 + nodes;

class Equations
{
  public:
    Equations(const std::vector<std::vector<CellColor>>& views, std::size_t cells)
        : cells_(views, cells), taps_(cells_.observations.size()), weights_(cells_.observations.size()), shared_(views.size(), 0)
    {
        for (std::size_t i = 0; i < weights_.size(); ++i)
        {
            taps_[i] = taps_at(cells_.observations[i].color->at);
            weights_[i] = cells_.observations[i].color->weight;
        }
        cells_.each_shared(
            [&](std::size_t begin, std::size_t end)
            {
                for (std::size_t i = begin; i < end; ++i)
                    shared_[cells_.observations[i].view] += static_cast<double>(weights_[i]);
            });
    }

    std::size_t unknowns() const { return shared_.size() * per_view; }

    /// From now on with the grids.
    void level() { with_grids_ = true; }

    /// Weights from the differences that `logs` leave in each cell.
    void reweigh(const std::array<Logs, 3>& logs, double scale)
    {
        std::vector<std::array<double, 3>> corrected;
        cells_.each_shared(
            [&](std::size_t begin, std::size_t end)
            {
                corrected.assign(end - begin, {});
                std::array<double, 3> mean{};
                double total = 0;
                for (std::size_t i = begin; i < end; ++i)
                {
                    total += static_cast<double>(weights_[i]);
                    for (std::size_t c = 0; c < 3; ++c)
                    {
                        double& value = corrected[i - begin][c];
                        value = static_cast<double>(cells_.observations[i].color->log_rgb[c]) + at(logs[c], i);
                        mean[c] += static_cast<double>(weights_[i]) * value;
                    }
                }
                for (std::size_t i = begin; i < end; ++i)
                {
                    double squares = 0;
                    for (std::size_t c = 0; c < 3; ++c)
                        squares += std::pow(corrected[i - begin][c] - mean[c] / total, 2) / 3;
                    weights_[i] = static_cast<float>(static_cast<double>(cells_.observations[i].color->weight) /
                                                     std::pow(1 + squares / (scale * scale), 2));
                }
            });
    }

    /// Conjugate gradients (Hestenes and Stiefel 1952) with the diagonal as preconditioner, from `logs` on.
    void improve(Logs& logs, std::size_t channel, const Progress& progress) const
    {
        Logs residual = pull([&](std::size_t i)
                             { return static_cast<double>(cells_.observations[i].color->log_rgb[channel]) + at(logs, i); });
        add_priors(logs, residual);
        for (double& value : residual)
            value = -value;
        const Logs diagonal = scaling();
        Logs direction(residual.size(), 0.0);
        double before = 1;
        for (int step = 0; step < steps_per_scale; ++step)
        {
            progress.check_canceled();
            double now = 0;
            for (std::size_t i = 0; i < residual.size(); ++i)
                now += residual[i] * residual[i] / diagonal[i];
            if (!(now > 0))
                return;
            for (std::size_t i = 0; i < residual.size(); ++i)
                direction[i] = residual[i] / diagonal[i] + (step > 0 ? now / before : 0.0) * direction[i];
            before = now;
            Logs image = pull([&](std::size_t i) { return at(direction, i); });
            add_priors(direction, image);
            double curvature = 0;
            for (std::size_t i = 0; i < image.size(); ++i)
                curvature += direction[i] * image[i];
            if (!(curvature > 0))
                return;
            for (std::size_t i = 0; i < image.size(); ++i)
            {
                logs[i] += now / curvature * direction[i];
                residual[i] -= now / curvature * image[i];
            }
        }
    }

  private:
    double at(const Logs& logs, std::size_t i) const
    {
        const double* const view = logs.data() + cells_.observations[i].view * per_view;
        double sum = view[0];
        for (std::size_t k = 0; k < 4; ++k)
            sum += static_cast<double>(taps_[i].share[k]) * view[1 + taps_[i].node[k]];
        return sum;
    }

    /// The gradient of half the data term if `value(i)` is the corrected color of observation i.
    template <class Value>
    Logs pull(const Value& value) const
    {
        Logs gradient(unknowns(), 0.0);
        std::vector<double> values;
        cells_.each_shared(
            [&](std::size_t begin, std::size_t end)
            {
                values.clear();
                double total = 0;
                double sum = 0;
                for (std::size_t i = begin; i < end; ++i)
                {
                    values.push_back(value(i));
                    total += static_cast<double>(weights_[i]);
                    sum += static_cast<double>(weights_[i]) * values.back();
                }
                for (std::size_t i = begin; i < end; ++i)
                {
                    const double force = static_cast<double>(weights_[i]) * (values[i - begin] - sum / total);
                    double* const view = gradient.data() + cells_.observations[i].view * per_view;
                    view[0] += force;
                    for (std::size_t k = 0; with_grids_ && k < 4; ++k)
                        view[1 + taps_[i].node[k]] += static_cast<double>(taps_[i].share[k]) * force;
                }
            });
        return gradient;
    }

    void add_priors(const Logs& logs, Logs& gradient) const
    {
        for (std::size_t v = 0; v < shared_.size(); ++v)
        {
            const double* const grid = logs.data() + v * per_view + 1;
            double* const pulled = gradient.data() + v * per_view + 1;
            pulled[-1] += number_prior * shared_[v] * grid[-1];
            const double each = shared_[v] / static_cast<double>(nodes);
            const auto join = [&](std::size_t a, std::size_t b)
            {
                const double force = stiffness * each * (grid[a] - grid[b]);
                pulled[a] += force;
                pulled[b] -= force;
            };
            for (std::size_t node = 0; node < nodes; ++node)
            {
                pulled[node] += grid_prior * each * grid[node];
                if (node % grid_columns + 1 < grid_columns)
                    join(node, node + 1);
                if (node + grid_columns < nodes)
                    join(node, node + grid_columns);
            }
        }
    }

    Logs scaling() const
    {
        Logs diagonal(unknowns(), 1e-9);
        for (std::size_t v = 0; v < shared_.size(); ++v)
        {
            diagonal[v * per_view] += number_prior * shared_[v];
            for (std::size_t node = 0; node < nodes; ++node)
                diagonal[v * per_view + 1 + node] += (grid_prior + 4 * stiffness) * shared_[v] / static_cast<double>(nodes);
        }
        for (std::size_t i = 0; i < weights_.size(); ++i)
        {
            double* const view = diagonal.data() + cells_.observations[i].view * per_view;
            view[0] += static_cast<double>(weights_[i]);
            for (std::size_t k = 0; k < 4; ++k)
                view[1 + taps_[i].node[k]] += static_cast<double>(weights_[i] * taps_[i].share[k] * taps_[i].share[k]);
        }
        return diagonal;
    }

    ByCell cells_;
    std::vector<Taps> taps_;
    std::vector<float> weights_;
    std::vector<double> shared_;  ///< Per view.
    bool with_grids_ = false;
};

}  // namespace

std::vector<CellColor> cell_colors(const SampleBlocks& samples, int side)
{
    std::vector<CellColor> result;
    for (const auto& block : samples)
        for (const TexelSample& sample : block)
        {
            const auto [least, most] = std::minmax_element(sample.rgb.begin(), sample.rgb.end());
            if (*least >= least_value && *most <= most_value)
                result.push_back({sample.texel,
                                  sample.weight,
                                  {std::log(sample.rgb[0]), std::log(sample.rgb[1]), std::log(sample.rgb[2])},
                                  sample.at});
        }
    if (result.size() > most_cells)
    {
        std::vector<std::uint32_t> hashes;
        for (const CellColor& color : result)
            hashes.push_back(noise::hash(square_of(color.cell, side)));
        std::nth_element(hashes.begin(), hashes.begin() + most_cells, hashes.end());
        std::erase_if(result,
                      [&](const CellColor& color) { return noise::hash(square_of(color.cell, side)) > hashes[most_cells]; });
    }
    std::sort(result.begin(), result.end(), [](const CellColor& a, const CellColor& b) { return a.cell < b.cell; });
    return result;
}

Gains no_gains()
{
    return {grid_columns, grid_rows, 3, 1.0F};
}

std::array<float, 3> gain_at(const Gains& gains, const std::array<float, 2>& at)
{
    std::array<float, 3> gain{};
    sample_bilinear(gains, at[0], 1 - at[1], gain.data());
    return gain;
}

std::vector<Gains> exposure_gains(const std::vector<std::vector<CellColor>>& views, std::size_t cells, const Progress& progress)
{
    Equations equations(views, cells);
    std::array<Logs, 3> logs;
    logs.fill(Logs(equations.unknowns(), 0.0));
    for (const double scale : scales)
    {
        if (scale <= leveled_from)
            equations.level();
        parallel_items(std::size_t{3}, 1, progress, [&](std::size_t c) { equations.improve(logs[c], c, progress); });
        equations.reweigh(logs, scale);
    }
    std::vector<Gains> gains(views.size(), no_gains());
    for (std::size_t v = 0; v < views.size(); ++v)
        for (std::size_t node = 0; node < nodes; ++node)
            for (std::size_t c = 0; c < 3; ++c)
                gains[v].values[3 * node + c] =
                    static_cast<float>(std::exp(logs[c][v * per_view] + logs[c][v * per_view + 1 + node]));
    return gains;
}

namespace
{

using Log = std::array<double, 3>;

Log log_of(const std::array<float, 3>& rgb)
{
    return {std::log(std::max(1e-3, static_cast<double>(rgb[0]))), std::log(std::max(1e-3, static_cast<double>(rgb[1]))),
            std::log(std::max(1e-3, static_cast<double>(rgb[2])))};
}

double mean_square(const Log& a, const Log& b)
{
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c)
        sum += (a[c] - b[c]) * (a[c] - b[c]) / 3;
    return sum;
}

/// The blend of every cell.
struct BlendedCells
{
    std::vector<Log> log_rgb;
    float median_distance = 0;
};

BlendedCells blended_cells(const std::vector<std::vector<CellColor>>& views, std::size_t cells, const std::vector<Gains>& gains,
                           const Blender& blend)
{
    const ByCell by_cell(views, cells);
    BlendedCells result{std::vector<Log>(cells), 0};
    std::vector<TexelSample> samples;
    std::vector<double> distances;
    for (std::size_t cell = 0; cell < cells; ++cell)
    {
        samples.clear();
        for (std::size_t i = by_cell.begins[cell]; i < by_cell.begins[cell + 1]; ++i)
        {
            const auto& [view, color] = by_cell.observations[i];
            std::array<float, 3> rgb = gain_at(gains[view], color->at);
            for (std::size_t c = 0; c < 3; ++c)
                rgb[c] *= std::exp(color->log_rgb[c]);
            samples.push_back({0, color->weight, rgb, {}});
        }
        if (samples.empty())
            continue;
        const std::array<float, 3> rgb = blend(samples);
        result.log_rgb[cell] = log_of(rgb);
        if (samples.size() > 1)
            for (const TexelSample& sample : samples)
                distances.push_back(std::sqrt(mean_square({double{sample.rgb[0]}, double{sample.rgb[1]}, double{sample.rgb[2]}},
                                                          {double{rgb[0]}, double{rgb[1]}, double{rgb[2]}})));
    }
    if (!distances.empty())
        result.median_distance = static_cast<float>(numerics::median(std::move(distances)));
    return result;
}

}  // namespace

BlendQuality blend_quality(const std::vector<std::vector<CellColor>>& views, int side, const std::vector<Gains>& gains,
                           const Blender& blend)
{
    const std::size_t cells = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    const BlendedCells blended = blended_cells(views, cells, gains, blend);
    BlendQuality result;
    result.median_distance = blended.median_distance;
    double all_squares = 0;
    double all_weights = 0;
    for (const auto& view : views)
    {
        struct Square
        {
            Log sum{};
            double squares = 0;
            double weight = 0;
        };
        std::map<std::uint32_t, Square> squares;
        for (const CellColor& color : view)
        {
            Square& square = squares[square_of(color.cell, side)];
            const auto weight = static_cast<double>(color.weight);
            Log off{};
            for (std::size_t c = 0; c < 3; ++c)
                off[c] = blended.log_rgb[color.cell][c] - static_cast<double>(color.log_rgb[c]);
            square.weight += weight;
            square.squares += weight * mean_square(off, {});
            for (std::size_t c = 0; c < 3; ++c)
                square.sum[c] += weight * off[c];
        }
        double sum = 0;
        double weight = 0;
        for (const auto& [place, square] : squares)
        {
            sum += square.squares - mean_square(square.sum, {}) / square.weight;
            weight += square.weight;
        }
        result.error.push_back(weight > 0 ? std::sqrt(std::max(0.0, sum) / weight) : 0);
        all_squares += std::max(0.0, sum);
        all_weights += weight;
    }
    result.total_error = all_weights > 0 ? std::sqrt(all_squares / all_weights) : 0;
    return result;
}

std::vector<std::uint32_t> overlapping_groups(const std::vector<std::vector<CellColor>>& views, std::size_t cells)
{
    numerics::DisjointSets sets(views.size());
    std::vector<std::uint32_t> first(cells, ~0U);
    for (std::uint32_t v = 0; v < views.size(); ++v)
        for (const CellColor& color : views[v])
        {
            if (first[color.cell] == ~0U)
                first[color.cell] = v;
            sets.join(first[color.cell], v);
        }
    std::vector<std::uint32_t> groups;
    for (std::uint32_t v = 0; v < views.size(); ++v)
        groups.push_back(sets.find(v));
    return groups;
}

}  // namespace fresco::from_frames
