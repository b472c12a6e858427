#include "catch.h"
#include "seen_cells.h"

#include <array>

using namespace fresco;
using namespace fresco::cover;
using numerics::SeenCell;

namespace
{

std::vector<SeenCell> cells(std::initializer_list<std::pair<int, int>> list)
{
    std::vector<SeenCell> seen;
    for (const auto& [cell, worth] : list)
        seen.emplace_back(static_cast<std::uint32_t>(cell), static_cast<std::uint32_t>(worth));
    return seen;
}

/// One row of pixels, of which those with a cosine >= 0 are valid.
UvMap row_of(const std::vector<std::array<float, 3>>& pixels)
{
    const int width = static_cast<int>(pixels.size());
    UvMap map{RasterF(width, 1, 2), RasterF(width, 1), RasterF(width, 1), Raster8(width, 1)};
    for (int x = 0; x < width; ++x)
    {
        const auto& [u, v, cosine] = pixels[static_cast<std::size_t>(x)];
        if (cosine < 0)
            continue;
        map.uv.at(x, 0, 0) = u;
        map.uv.at(x, 0, 1) = v;
        map.cosine.at(x, 0) = cosine;
        map.valid.at(x, 0) = 1;
    }
    return map;
}

}  // namespace

TEST_CASE("pixels fall into cells, of which each keeps its best pixel", "[frames.cover]")
{
    // 4 x 4 cells. Two pixels in cell (1, 0), the upper right corner, and one that is not valid.
    const auto map = row_of({{0.30F, 0.1F, 0.2F}, {1, 1, 1}, {0.45F, 0.2F, 0.6F}, {0.9F, 0.1F, -1}});
    const auto seen = seen_cells(map, 4, 1, {.angle_weight = 1, .sharpness_weight = 0});
    // (1 + 0.6) / 2 and (1 + 1) / 2 of 254, plus 1.
    CHECK(seen == cells({{1, 204}, {15, 255}}));
    // Half as sharp as can be: (1 + 0.5 + 2 * 0.6) / 4.
    CHECK(seen_cells(map, 4, 0.5, {.angle_weight = 2, .sharpness_weight = 1}).front() == SeenCell(1, 172));
    CHECK(seen_cells(map, 4, 0, {.angle_weight = 0, .sharpness_weight = 0}) == cells({{1, 255}, {15, 255}}));
    CHECK(seen_cells(row_of({{0, 0, -1}}), 4, 1, {}).empty());
    CHECK(seen_cells(row_of({{1, 1, 0}}), 4096, 0, {}).front().cell() == SeenCell::most_cells - 1);
}
