#include "tile_bins.h"

#include "clip.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace raster
{

Grid::Grid(const fresco::Intrinsics& k, std::uint32_t first)
    : width(k.width), height(k.height), bits(16), tiles_across((k.width + Tile::width - 1) / Tile::width), first_tile(first)
{
    // The guard of the frustum reaches from minus one picture to plus two.
    while (2 * std::int64_t{std::max(width, height)} << bits > coordinate_limit)
        --bits;
    const double one = 1 << bits;
    scale_x = k.fx * one;
    scale_y = k.fy * one;
    shift_x = (k.cx - 0.5) * one;
    shift_y = (k.cy - 0.5) * one;
    const int tiles_down = (k.height + Tile::height - 1) / Tile::height;
    end_tile = first + static_cast<std::uint32_t>(tiles_across) * static_cast<std::uint32_t>(tiles_down);
}

namespace
{

void order(std::uint32_t& a, std::uint32_t& b)
{
    const std::uint32_t less = std::min(a, b);
    b = std::max(a, b);
    a = less;
}

}  // namespace

void TileBins::fill(const fresco::Mesh& mesh, std::size_t begin, std::size_t end, const std::vector<Projected>& projected,
                    const Frustum& frustum, const fresco::IntoCamera& into_camera, const std::vector<Grid>& grids)
{
    pieces_.clear();
    entries_.clear();
    for (std::size_t f = begin; f < end; ++f)
    {
        fresco::Triangle t = mesh.triangles[f];
        const std::uint8_t a = projected[t[0]].sides;
        const std::uint8_t b = projected[t[1]].sides;
        const std::uint8_t c = projected[t[2]].sides;
        if (out_of_sight(a, b, c))
            continue;
        const auto face = static_cast<std::uint32_t>(f);
        // In one order whatever the face begins with: faces with the same corners get the same depths, and the first one is seen.
        order(t[0], t[1]);
        order(t[1], t[2]);
        order(t[0], t[1]);
        if (!needs_clipping(a, b, c))
        {
            add(face, projected[t[0]], projected[t[1]], projected[t[2]], grids);
            continue;
        }
        const Clipped part = clipped({into_camera.point(mesh.positions[t[0]]), into_camera.point(mesh.positions[t[1]]),
                                      into_camera.point(mesh.positions[t[2]])},
                                     frustum);
        for (std::size_t i = 2; i < part.count; ++i)
            add(face, part.corners[0], part.corners[i - 1], part.corners[i], grids);
    }
    sort(grids.back().end_tile);
}

void TileBins::add(std::uint32_t face, const Projected& a, const Projected& b, const Projected& c, const std::vector<Grid>& grids)
{
    for (const Grid& grid : grids)
    {
        const Piece piece{
            {grid.x(a), grid.x(b), grid.x(c)}, {grid.y(a), grid.y(b), grid.y(c)}, {a.nearness, b.nearness, c.nearness}, face};
        const auto [x_min, x_max] = std::minmax({piece.x[0], piece.x[1], piece.x[2]});
        const auto [y_min, y_max] = std::minmax({piece.y[0], piece.y[1], piece.y[2]});
        const int round_up = (1 << grid.bits) - 1;
        const int first_x = std::max((x_min + round_up) >> grid.bits, 0);
        const int first_y = std::max((y_min + round_up) >> grid.bits, 0);
        const int last_x = std::min(x_max >> grid.bits, grid.width - 1);
        const int last_y = std::min(y_max >> grid.bits, grid.height - 1);
        if (first_x > last_x || first_y > last_y)
            continue;
        const auto number = static_cast<std::uint32_t>(pieces_.size());
        pieces_.push_back(piece);
        for (int y = first_y / Tile::height; y <= last_y / Tile::height; ++y)
            for (int x = first_x / Tile::width; x <= last_x / Tile::width; ++x)
                entries_.push_back({grid.first_tile + static_cast<std::uint32_t>(y * grid.tiles_across + x), number});
    }
}

void TileBins::sort(std::uint32_t tiles)
{
    starts_.assign(std::size_t{tiles} + 1, 0);
    for (const Entry& entry : entries_)
        ++starts_[entry.tile + 1];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    sorted_.resize(entries_.size());
    std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (const Entry& entry : entries_)
        sorted_[next[entry.tile]++] = entry.piece;
}

}  // namespace raster
