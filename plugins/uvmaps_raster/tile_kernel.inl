// The loop of tile_kernel.h with vectors of FRESCO_LANES doubles. Compiled several times for other processors, so that it must
// not use anything inline from elsewhere: the linker might take this copy for all.

#include "tile_kernel.h"

namespace raster
{
namespace
{

constexpr int lanes = FRESCO_LANES;

typedef double Doubles __attribute__((vector_size(lanes * 8)));
typedef std::int64_t Longs __attribute__((vector_size(lanes * 8)));
typedef std::int64_t LooseLongs __attribute__((vector_size(lanes * 8), aligned(8), may_alias));
typedef float Floats __attribute__((vector_size(lanes * 4)));
typedef std::int32_t Ints __attribute__((vector_size(lanes * 4)));

int least(int a, int b)
{
    return a < b ? a : b;
}

int most(int a, int b)
{
    return a > b ? a : b;
}

/// Twice the area of the triangle that an edge forms with a pixel centre, in units of the fraction: whole numbers, above 0
/// inside.
struct Edge
{
    double start;     ///< At the first pixel.
    double to_right;  ///< From pixel to pixel.
    double down;
    bool owns;  ///< Whether a pixel centre on the edge is inside.
};

/// `x`, `y`: of the edge's first corner from the first pixel's centre; `dx`, `dy`: to its other corner.
Edge edge_along(double x, double y, double dx, double dy, double one)
{
    return {dy * x - dx * y, -dy * one, dx * one, dy > 0 || (dy == 0 && dx > 0)};
}

Doubles all_of(double value)
{
    return Doubles{} + value;
}

void draw_piece(const Piece& piece, int bits, int tile_x, int tile_y, std::uint64_t* keys)
{
    const int x_min = least(least(piece.x[0], piece.x[1]), piece.x[2]);
    const int y_min = least(least(piece.y[0], piece.y[1]), piece.y[2]);
    const int x_max = most(most(piece.x[0], piece.x[1]), piece.x[2]);
    const int y_max = most(most(piece.y[0], piece.y[1]), piece.y[2]);
    if (x_max - x_min > narrow_limit || y_max - y_min > narrow_limit)
        return draw_wide(piece, bits, tile_x, tile_y, keys);
    const int round_up = (1 << bits) - 1;
    const int first_x = most((x_min + round_up) >> bits, tile_x);
    const int first_y = most((y_min + round_up) >> bits, tile_y);
    const int last_x = least(x_max >> bits, tile_x + tile_width - 1);
    const int last_y = least(y_max >> bits, tile_y + tile_height - 1);

    double x[3];
    double y[3];
    for (int i = 0; i < 3; ++i)
    {
        x[i] = piece.x[i] - (first_x << bits);
        y[i] = piece.y[i] - (first_y << bits);
    }
    const double area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
    if (area == 0)
        return;
    const double way = area > 0 ? 1 : -1;
    const double one = 1 << bits;
    const Edge a = edge_along(x[1], y[1], way * (x[2] - x[1]), way * (y[2] - y[1]), one);
    const Edge b = edge_along(x[2], y[2], way * (x[0] - x[2]), way * (y[0] - y[2]), one);
    const Edge c = edge_along(x[0], y[0], way * (x[1] - x[0]), way * (y[1] - y[0]), one);
    // Whole numbers: one that is not above 0 is below 1/2.
    const double least_a = a.owns ? 0 : 0.5;
    const double least_b = b.owns ? 0 : 0.5;
    const double least_c = c.owns ? 0 : 0.5;

    // Nearness is linear in the picture: that of corner 0 and shares of the differences to the others.
    const double share = 1 / (way * area);
    const double origin = piece.nearness[0];
    const double to_b = (piece.nearness[1] - origin) * share;
    const double to_c = (piece.nearness[2] - origin) * share;
    const auto low = static_cast<std::int64_t>(~piece.face & 0xFFFFFFFFU);

    Doubles ramp;
    for (int lane = 0; lane < lanes; ++lane)
        ramp[lane] = lane;
    Doubles row_a = all_of(a.start) + ramp * a.to_right;
    Doubles row_b = all_of(b.start) + ramp * b.to_right;
    Doubles row_c = all_of(c.start) + ramp * c.to_right;
    std::uint64_t* row = keys + (first_y - tile_y) * tile_stride + (first_x - tile_x);
    for (int rows = last_y - first_y; rows >= 0; --rows, row += tile_stride)
    {
        Doubles at_a = row_a;
        Doubles at_b = row_b;
        Doubles at_c = row_c;
        for (int i = 0; i <= last_x - first_x; i += lanes)
        {
            const Longs inside = (at_a >= least_a) & (at_b >= least_b) & (at_c >= least_c);
            const Doubles nearness = origin + (at_b * to_b + at_c * to_c);
            const Longs key = (__builtin_convertvector((Ints) __builtin_convertvector(nearness, Floats), Longs) << 32) | low;
            LooseLongs* place = reinterpret_cast<LooseLongs*>(row + i);
            const Longs seen = *place;
            const Longs nearer = (key > seen) & inside;
            *place = (key & nearer) | (seen & ~nearer);
            at_a += lanes * a.to_right;
            at_b += lanes * b.to_right;
            at_c += lanes * c.to_right;
        }
        row_a += a.down;
        row_b += b.down;
        row_c += c.down;
    }
}

void draw(const Piece* pieces, const std::uint32_t* numbers, std::size_t count, int bits, int x, int y, std::uint64_t* keys)
{
    constexpr std::size_t ahead = 6;
    for (std::size_t i = 0; i < count; ++i)
    {
        if (i + ahead < count)
        {
            __builtin_prefetch(pieces + numbers[i + ahead]);
            __builtin_prefetch(&pieces[numbers[i + ahead]].face);
        }
        draw_piece(pieces[numbers[i]], bits, x, y, keys);
    }
}

}  // namespace

const TileKernel* FRESCO_KERNEL()
{
    static constexpr TileKernel kernel{FRESCO_KERNEL_NAME, draw};
    return &kernel;
}

}  // namespace raster
