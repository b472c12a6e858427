#include "exposure.h"

#include <fresco/numerics/bilinear.h>
#include <fresco/numerics/noise.h>
#include <fresco/numerics/numerics.h>
#include <fresco/parallel.h>

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
constexpr float number_prior = 0.005F;
constexpr float grid_prior = 0.02F;
constexpr float stiffness = 0.5F;

/// Grids are fitted from this scale on, when the weights of what is out of place have gone.
constexpr float leveled_from = 0.2F;
constexpr std::array<float, 8> scales{0.8F, 0.55F, 0.4F, 0.28F, 0.2F, 0.14F, 0.1F, 0.1F};
constexpr int steps_per_scale = 20;
/// A scale's steps end where the squared residual is this small a part of what it was.
constexpr float settled_share = 1e-4F;

std::uint32_t square_of(std::uint32_t cell, int side)
{
    const auto width = static_cast<std::uint32_t>(side);
    return cell / width / square_side * width + cell % width / square_side;
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

/// The unknowns of all channels: per view a number, then a grid.
using Logs = std::vector<Four>;
constexpr std::size_t per_view = 1 + nodes;

/// The unknowns that an observation depends on: its view's number, and the nodes from `corner` on, to the right and below, with
/// their shares.
struct Taps
{
    std::uint32_t number = 0;
    std::uint32_t corner = 0;
    std::array<float, 4> share{};
};

constexpr std::array<std::uint32_t, 4> around{0, 1, grid_columns, grid_columns + 1};

Taps taps_at(std::uint32_t view, const std::array<float, 2>& at)
{
    const auto x = numerics::between<float>(at[0] * grid_columns - 0.5F, grid_columns);
    const auto y = numerics::between<float>(at[1] * grid_rows - 0.5F, grid_rows);
    // At the last node, which has none behind it, the one before has no share.
    const int column = std::min(x.first, grid_columns - 2);
    const int row = std::min(y.first, grid_rows - 2);
    const float right = x.share + static_cast<float>(x.first - column);
    const float down = y.share + static_cast<float>(y.first - row);
    const auto number = static_cast<std::uint32_t>(view * per_view);
    return {number,
            number + 1 + static_cast<std::uint32_t>(row * grid_columns + column),
            {(1 - right) * (1 - down), right * (1 - down), (1 - right) * down, right * down}};
}

class Equations
{
  public:
    Equations(const std::vector<std::vector<CellColor>>& views, std::size_t cells)
        : cells_(views, cells), taps_(cells_.observations.size()), weights_(taps_.size()), colors_(taps_.size()),
          shared_(views.size(), 0)
    {
        for (std::size_t i = 0; i < weights_.size(); ++i)
        {
            const auto& [view, color] = cells_.observations[i];
            taps_[i] = taps_at(view, color->at);
            weights_[i] = color->weight;
            colors_[i] = Four{color->log_rgb[0], color->log_rgb[1], color->log_rgb[2], 0};
        }
        cells_.each_shared(
            [&](std::size_t begin, std::size_t end)
            {
                for (std::size_t i = begin; i < end; ++i)
                    shared_[cells_.observations[i].view] += weights_[i];
            });
    }

    std::size_t unknowns() const { return shared_.size() * per_view; }

    /// From now on with the grids.
    void level() { with_grids_ = true; }

    /// Weights from the differences that `logs` leave in each cell.
    void reweigh(const Logs& logs, float scale)
    {
        Logs corrected;
        cells_.each_shared(
            [&](std::size_t begin, std::size_t end)
            {
                corrected.clear();
                Four mean{};
                float total = 0;
                for (std::size_t i = begin; i < end; ++i)
                {
                    corrected.push_back(colors_[i] + at(logs, i));
                    total += weights_[i];
                    mean += weights_[i] * corrected.back();
                }
                mean /= total;
                for (std::size_t i = begin; i < end; ++i)
                {
                    const Four off = corrected[i - begin] - mean;
                    const Four squares = off * off;
                    const float share = 1 + (squares[0] + squares[1] + squares[2]) / (3 * scale * scale);
                    weights_[i] = cells_.observations[i].color->weight / (share * share);
                }
            });
    }

    /// Conjugate gradients (Hestenes and Stiefel 1952) with the diagonal as preconditioner, from `logs` on; all channels at once.
    void improve(Logs& logs, const Progress& progress) const
    {
        Logs residual = pull([&](std::size_t i) { return colors_[i] + at(logs, i); });
        add_priors(logs, residual);
        for (Four& value : residual)
            value = -value;
        const std::vector<float> diagonal = scaling();
        Logs direction(residual.size(), Four{});
        Four before = Four{} + 1;
        Four enough{};
        for (int step = 0; step < steps_per_scale; ++step)
        {
            progress.check_canceled();
            const Four now = total([&](std::size_t i) { return residual[i] * residual[i] / diagonal[i]; });
            if (step == 0)
                enough = now * settled_share;
            const Four kept = step > 0 ? ratio(now, before) : Four{};
            if (!(now[0] > enough[0] || now[1] > enough[1] || now[2] > enough[2]))
                return;
            for (std::size_t i = 0; i < residual.size(); ++i)
                direction[i] = residual[i] / diagonal[i] + kept * direction[i];
            before = now;
            Logs image = pull([&](std::size_t i) { return at(direction, i); });
            add_priors(direction, image);
            const Four length = ratio(now, total([&](std::size_t i) { return direction[i] * image[i]; }));
            for (std::size_t i = 0; i < image.size(); ++i)
            {
                logs[i] += length * direction[i];
                residual[i] -= length * image[i];
            }
        }
    }

  private:
    /// Per channel; 0 where nothing is left.
    static Four ratio(Four a, Four b) { return b > 0 ? a / b : Four{}; }

    /// Over all unknowns.
    template <class Value>
    Four total(const Value& value) const
    {
        std::array<double, 3> sum{};
        for (std::size_t i = 0; i < unknowns(); ++i)
        {
            const Four part = value(i);
            for (std::size_t c = 0; c < 3; ++c)
                sum[c] += static_cast<double>(part[c]);
        }
        return Four{static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2]), 0};
    }

    Four at(const Logs& logs, std::size_t i) const
    {
        const Taps& taps = taps_[i];
        Four sum = logs[taps.number];
        for (std::size_t k = 0; k < 4; ++k)
            sum += taps.share[k] * logs[taps.corner + around[k]];
        return sum;
    }

    /// The gradient of half the data term if `value(i)` is the corrected color of observation i.
    template <class Value>
    Logs pull(const Value& value) const
    {
        Logs gradient(unknowns(), Four{});
        Logs values;
        cells_.each_shared(
            [&](std::size_t begin, std::size_t end)
            {
                values.clear();
                float weight = 0;
                Four sum{};
                for (std::size_t i = begin; i < end; ++i)
                {
                    values.push_back(value(i));
                    weight += weights_[i];
                    sum += weights_[i] * values.back();
                }
                sum /= weight;
                for (std::size_t i = begin; i < end; ++i)
                {
                    const Four force = weights_[i] * (values[i - begin] - sum);
                    gradient[taps_[i].number] += force;
                    for (std::size_t k = 0; with_grids_ && k < 4; ++k)
                        gradient[taps_[i].corner + around[k]] += taps_[i].share[k] * force;
                }
            });
        return gradient;
    }

    void add_priors(const Logs& logs, Logs& gradient) const
    {
        for (std::size_t v = 0; v < shared_.size(); ++v)
        {
            const Four* const grid = logs.data() + v * per_view + 1;
            Four* const pulled = gradient.data() + v * per_view + 1;
            pulled[-1] += number_prior * shared_[v] * grid[-1];
            const float each = shared_[v] / static_cast<float>(nodes);
            const auto join = [&](std::size_t a, std::size_t b)
            {
                const Four force = stiffness * each * (grid[a] - grid[b]);
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

    std::vector<float> scaling() const
    {
        std::vector<float> diagonal(unknowns(), 1e-9F);
        for (std::size_t v = 0; v < shared_.size(); ++v)
        {
            diagonal[v * per_view] += number_prior * shared_[v];
            for (std::size_t node = 0; node < nodes; ++node)
                diagonal[v * per_view + 1 + node] += (grid_prior + 4 * stiffness) * shared_[v] / static_cast<float>(nodes);
        }
        for (std::size_t i = 0; i < weights_.size(); ++i)
        {
            diagonal[taps_[i].number] += weights_[i];
            for (std::size_t k = 0; k < 4; ++k)
                diagonal[taps_[i].corner + around[k]] += weights_[i] * taps_[i].share[k] * taps_[i].share[k];
        }
        return diagonal;
    }

    ByCell cells_;
    std::vector<Taps> taps_;
    std::vector<float> weights_;
    std::vector<Four> colors_;
    std::vector<float> shared_;  ///< Per view.
    bool with_grids_ = false;
};

}  // namespace

std::vector<CellColor> cell_colors(std::span<const TexelSample> samples, int side)
{
    std::vector<CellColor> result;
    for (const TexelSample& sample : samples)
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
        std::vector<std::uint32_t> hashes(result.size());
        std::ranges::transform(result, hashes.begin(),
                               [side](const CellColor& color) { return noise::hash(square_of(color.cell, side)); });
        std::nth_element(hashes.begin(), hashes.begin() + most_cells, hashes.end());
        std::erase_if(result,
                      [&](const CellColor& color) { return noise::hash(square_of(color.cell, side)) > hashes[most_cells]; });
    }
    std::sort(result.begin(), result.end(), [](const CellColor& a, const CellColor& b) { return a.cell < b.cell; });
    return result;
}

Gains no_gains()
{
    return {grid_columns, grid_rows, 4, 1.0F};
}

std::array<float, 3> gain_at(const Gains& gains, const std::array<float, 2>& at)
{
    const Four gain = four_between(gains, at[0], at[1]);
    return {gain[0], gain[1], gain[2]};
}

std::vector<Gains> exposure_gains(const std::vector<std::vector<CellColor>>& views, std::size_t cells, const Progress& progress)
{
    Equations equations(views, cells);
    Logs logs(equations.unknowns(), Four{});
    for (const float scale : scales)
    {
        if (scale <= leveled_from)
            equations.level();
        equations.improve(logs, progress);
        equations.reweigh(logs, scale);
    }
    std::vector<Gains> gains(views.size(), no_gains());
    for (std::size_t v = 0; v < views.size(); ++v)
        for (std::size_t node = 0; node < nodes; ++node)
            for (std::size_t c = 0; c < 3; ++c)
                gains[v].values[4 * node + c] =
                    static_cast<float>(std::exp(double{logs[v * per_view][c] + logs[v * per_view + 1 + node][c]}));
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
