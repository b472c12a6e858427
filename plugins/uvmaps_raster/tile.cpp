#include "tile.h"

#include <fresco/processor.h>

#include <algorithm>
#include <bit>

namespace raster
{
namespace
{

/// Twice the area of the triangle that an edge from (x, y) along (dx, dy) forms with a point: above 0 inside.
struct Edge
{
    std::int64_t x, y, dx, dy;

    std::int64_t at(std::int64_t px, std::int64_t py) const { return dx * (py - y) - dy * (px - x); }
    /// -1 where points on the edge itself are outside.
    std::int64_t bias() const { return dy > 0 || (dy == 0 && dx > 0) ? 0 : -1; }
};

/// The edge from corner i to corner j; `way` is -1 for a piece that runs the other way round.
Edge edge_of(const Piece& piece, std::size_t i, std::size_t j, std::int64_t way)
{
    return {piece.x[i], piece.y[i], way * (std::int64_t{piece.x[j]} - piece.x[i]), way * (std::int64_t{piece.y[j]} - piece.y[i])};
}

std::uint64_t key(float nearness, std::uint32_t face)
{
    return (std::uint64_t{std::bit_cast<std::uint32_t>(nearness)} << 32) | (~face & 0xFFFFFFFFU);
}

}  // namespace

const TileKernel& fastest_kernel()
{
    static const auto& fastest = fresco::fastest_of(avx512_kernel(), avx2_kernel(), base_kernel());
    return fastest;
}

void Tile::clear(int x, int y)
{
    x_ = x;
    y_ = y;
    keys_.fill(0);
}

void Tile::row(int row, int columns, std::uint32_t* faces) const
{
    const std::uint64_t* keys = keys_.data() + std::ptrdiff_t{row} * tile_stride;
    for (int i = 0; i < columns; ++i)
        faces[i] = ~static_cast<std::uint32_t>(keys[i]);
}

void draw_wide(const Piece& piece, int bits, int tile_x, int tile_y, std::uint64_t* keys)
{
    const auto [x_min, x_max] = std::minmax({piece.x[0], piece.x[1], piece.x[2]});
    const auto [y_min, y_max] = std::minmax({piece.y[0], piece.y[1], piece.y[2]});
    const int round_up = (1 << bits) - 1;
    const int first_x = std::max((x_min + round_up) >> bits, tile_x);
    const int first_y = std::max((y_min + round_up) >> bits, tile_y);
    const int last_x = std::min(x_max >> bits, tile_x + tile_width - 1);
    const int last_y = std::min(y_max >> bits, tile_y + tile_height - 1);
    if (first_x > last_x || first_y > last_y)
        return;

    const std::int64_t area = edge_of(piece, 0, 1, 1).at(piece.x[2], piece.y[2]);
    if (area == 0)
        return;
    const std::int64_t way = area > 0 ? 1 : -1;
    const Edge a = edge_of(piece, 1, 2, way);
    const Edge b = edge_of(piece, 2, 0, way);
    const Edge c = edge_of(piece, 0, 1, way);
    const std::int64_t px = std::int64_t{first_x} << bits;
    const std::int64_t py = std::int64_t{first_y} << bits;
    std::int64_t row_a = a.at(px, py) + a.bias();
    std::int64_t row_b = b.at(px, py) + b.bias();
    std::int64_t row_c = c.at(px, py) + c.bias();

    // Nearness is linear in the picture: that of corner 0 and shares of the differences to the others.
    const double share = 1 / static_cast<double>(way * area);
    const double to_b = (double{piece.nearness[1]} - double{piece.nearness[0]}) * share;
    const double to_c = (double{piece.nearness[2]} - double{piece.nearness[0]}) * share;
    for (int y = first_y; y <= last_y; ++y)
    {
        std::int64_t at_a = row_a;
        std::int64_t at_b = row_b;
        std::int64_t at_c = row_c;
        std::uint64_t* row = keys + std::ptrdiff_t{y - tile_y} * tile_stride;
        for (int x = first_x; x <= last_x; ++x)
        {
            if ((at_a | at_b | at_c) >= 0)
            {
                const double nearness =
                    double{piece.nearness[0]} + (static_cast<double>(at_b) * to_b + static_cast<double>(at_c) * to_c);
                std::uint64_t& seen = row[x - tile_x];
                seen = std::max(seen, key(static_cast<float>(nearness), piece.face));
            }
            at_a -= a.dy << bits;
            at_b -= b.dy << bits;
            at_c -= c.dy << bits;
        }
        row_a += a.dx << bits;
        row_b += b.dx << bits;
        row_c += c.dx << bits;
    }
}

}  // namespace raster
