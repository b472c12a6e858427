#include "seen_cells.h"

#include <algorithm>
#include <cmath>

namespace fresco::cover
{

using numerics::SeenCell;

std::vector<SeenCell> seen_cells(const UvMap& map, int cells_px, double sharpness, const WorthRules& rules)
{
    const double most = 1 + rules.angle_weight + rules.sharpness_weight;
    const double base = 1 + rules.sharpness_weight * sharpness;
    const auto along = [&](float share)
    { return std::clamp(static_cast<int>(share * static_cast<float>(cells_px)), 0, cells_px - 1); };
    std::vector<SeenCell> seen;
    for (std::size_t i = 0; i < map.valid.values.size(); ++i)
    {
        if (map.valid.values[i] == 0)
            continue;
        const auto cell = static_cast<std::uint32_t>(along(map.uv.values[2 * i + 1]) * cells_px + along(map.uv.values[2 * i]));
        const double worth = (base + rules.angle_weight * static_cast<double>(map.cosine.values[i])) / most;
        seen.emplace_back(cell, static_cast<std::uint32_t>(std::lround(1 + worth * (SeenCell::best_worth - 1))));
    }
    // By cell, the best first.
    std::ranges::sort(seen, {}, [](SeenCell cell) { return std::pair(cell.cell(), -static_cast<int>(cell.worth())); });
    const auto rest = std::ranges::unique(seen, {}, &SeenCell::cell);
    seen.erase(rest.begin(), rest.end());
    seen.shrink_to_fit();
    return seen;
}

}  // namespace fresco::cover
