#include "palette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

using namespace fresco;

namespace
{
constexpr float cell = 2;
constexpr float reach = 10;
constexpr int reach_cells = 6;  // For colors that are half a cell off.
// Cells of L* in 0..100, a* and b* of any displayed color, and a rim that is_near may look into.
constexpr int least_l = -reach_cells;
constexpr int count_l = 51 + 2 * reach_cells;
constexpr int least_ab = -64 - reach_cells;
constexpr int count_ab = 129 + 2 * reach_cells;

struct Cell
{
    int l, a, b;
};

Cell cell_of(Vec3f lab)
{
    // Halves go to the even cell, as NumPy rounds them.
    const auto rounded = [](float v, int least, int most)
    { return std::clamp(static_cast<int>(std::nearbyint(v / cell)), least, most); };
    return {rounded(lab.x, 0, 50), rounded(lab.y, -64, 64), rounded(lab.z, -64, 64)};
}

std::size_t index_of(Cell c)
{
    return (static_cast<std::size_t>(c.l - least_l) * count_ab + static_cast<std::size_t>(c.a - least_ab)) * count_ab +
           static_cast<std::size_t>(c.b - least_ab);
}

/// Steps between cells that may be within reach, the shortest first.
const std::vector<Cell>& steps()
{
    static const std::vector<Cell> result = []
    {
        std::vector<Cell> all;
        for (int l = -reach_cells; l <= reach_cells; ++l)
            for (int a = -reach_cells; a <= reach_cells; ++a)
                for (int b = -reach_cells; b <= reach_cells; ++b)
                    // A color may be half a cell off along each axis.
                    if (std::sqrt(static_cast<float>(l * l + a * a + b * b)) * cell <= reach + 1.7321F * cell / 2)
                        all.push_back({l, a, b});
        std::ranges::stable_sort(all, {}, [](const Cell& c) { return c.l * c.l + c.a * c.a + c.b * c.b; });
        return all;
    }();
    return result;
}
}  // namespace

Palette::Palette(const RasterF& lab) : cells_(std::size_t{count_l} * count_ab * count_ab)
{
    for (std::size_t i = 0; i + 2 < lab.values.size(); i += 3)
        cells_[index_of(cell_of({lab.values[i], lab.values[i + 1], lab.values[i + 2]}))] = 1;
}

bool Palette::is_near(Vec3f color) const
{
    const Cell own = cell_of(color);
    for (const Cell& step : steps())
    {
        const Cell c{own.l + step.l, own.a + step.a, own.b + step.b};
        if (cells_[index_of(c)] == 0)
            continue;
        const Vec3f away = color - Vec3f{static_cast<float>(c.l), static_cast<float>(c.a), static_cast<float>(c.b)} * cell;
        if (dot(away, away) <= reach * reach)
            return true;
    }
    return false;
}
