#include <fresco/numerics/greedy_cover.h>

#include <algorithm>
#include <queue>

namespace fresco::numerics
{
namespace
{

/// Upper bound of a frame's gain: the gain when it was last computed, as gains never grow.
struct Bound
{
    std::int64_t gain = 0;
    std::size_t frame = 0;
    std::size_t round = 0;  ///< Number of picks at that time.

    bool operator<(const Bound& other) const { return gain != other.gain ? gain < other.gain : frame > other.frame; }
};

std::int64_t gain_of(const std::vector<SeenCell>& seen, const std::vector<std::uint8_t>& best)
{
    std::int64_t gain = 0;
    for (const SeenCell cell : seen)
        gain += std::max<std::int64_t>(0, std::int64_t{cell.worth()} - best[cell.cell()]);
    return gain;
}

/// Returns the number of cells that were not seen before.
std::int64_t take(const std::vector<SeenCell>& seen, std::vector<std::uint8_t>& best)
{
    std::int64_t new_cells = 0;
    for (const SeenCell cell : seen)
    {
        auto& worth = best[cell.cell()];
        new_cells += worth == 0;
        worth = std::max(worth, static_cast<std::uint8_t>(cell.worth()));
    }
    return new_cells;
}

}  // namespace

std::vector<Pick> greedy_order(const std::vector<std::vector<SeenCell>>& frames, std::size_t cell_count, const Progress& progress)
{
    std::vector<std::uint8_t> best(cell_count);
    std::priority_queue<Bound> bounds;
    for (std::size_t i = 0; i < frames.size(); ++i)
        bounds.push({gain_of(frames[i], best), i, 0});
    std::vector<Pick> order;
    while (!bounds.empty() && bounds.top().gain > 0)
    {
        progress.check_canceled();
        Bound next = bounds.top();
        bounds.pop();
        if (next.round == order.size())
        {
            order.push_back({next.frame, take(frames[next.frame], best)});
            continue;
        }
        next.gain = gain_of(frames[next.frame], best);
        next.round = order.size();
        bounds.push(next);
    }
    return order;
}

std::int64_t cells_seen(const std::vector<std::vector<SeenCell>>& frames, std::span<const std::size_t> chosen,
                        std::size_t cell_count)
{
    std::vector<std::uint8_t> best(cell_count);
    std::int64_t cells = 0;
    for (const std::size_t frame : chosen)
        cells += take(frames[frame], best);
    return cells;
}

std::vector<std::size_t> evenly_spread(std::size_t count, std::size_t of)
{
    std::vector<std::size_t> numbers(count);
    for (std::size_t i = 0; i < count; ++i)
        numbers[i] = (2 * i + 1) * of / (2 * count);
    return numbers;
}

std::size_t picks_needed(const std::vector<Pick>& order, double target, std::size_t most)
{
    std::int64_t all = 0;
    for (const Pick& pick : order)
        all += pick.new_cells;
    std::int64_t seen = 0;
    std::size_t picks = 0;
    while (picks < std::min(most, order.size()) && static_cast<double>(seen) < target * static_cast<double>(all))
        seen += order[picks++].new_cells;
    return picks;
}

}  // namespace fresco::numerics
