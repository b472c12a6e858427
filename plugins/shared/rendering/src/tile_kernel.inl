// The loop of tile_kernel.h with vectors of FRESCO_VECTOR_BYTES. Compiled several times for other processors, so that it must
// not use anything inline from elsewhere: the linker might take this copy for all.

#include <fresco/rendering/tile_kernel.h>

#if defined(__clang__)
#define FRESCO_SHUFFLE(a, b, places, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define FRESCO_SHUFFLE(a, b, places, ...) __builtin_shuffle(a, b, places{__VA_ARGS__})
#endif

namespace fresco::rendering
{
#if FRESCO_VECTOR_BYTES > 0
namespace
{

constexpr int lanes = FRESCO_VECTOR_BYTES / 8;

typedef double Doubles __attribute__((vector_size(lanes * 8)));
typedef std::int64_t Longs __attribute__((vector_size(lanes * 8)));
typedef std::int64_t LooseLongs __attribute__((vector_size(lanes * 8), aligned(8), may_alias));
typedef float Floats __attribute__((vector_size(lanes * 4)));
typedef std::int32_t Ints __attribute__((vector_size(lanes * 4)));

/// One for each of a piece's edges.
typedef double Three __attribute__((vector_size(32)));
typedef std::int64_t ThreeLongs __attribute__((vector_size(32)));
typedef std::int32_t ThreeInts __attribute__((vector_size(16)));

int least(int a, int b)
{
    return a < b ? a : b;
}

int most(int a, int b)
{
    return a > b ? a : b;
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

    // Corners 1, 2 and 0 from the center of the first pixel, where the edges begin that face corners 0, 1 and 2.
    const Three x = __builtin_convertvector(ThreeInts{piece.x[1], piece.x[2], piece.x[0], 0} - (first_x << bits), Three);
    const Three y = __builtin_convertvector(ThreeInts{piece.y[1], piece.y[2], piece.y[0], 0} - (first_y << bits), Three);
    Three dx = FRESCO_SHUFFLE(x, x, ThreeLongs, 1, 2, 0, 3) - x;
    Three dy = FRESCO_SHUFFLE(y, y, ThreeLongs, 1, 2, 0, 3) - y;
    // Twice the area of the triangle that an edge forms with a pixel's center: a whole number, above 0 inside.
    const double area = dx[2] * dy[0] - dy[2] * dx[0];
    if (area == 0)
        return;
    const double way = __builtin_copysign(1.0, area);
    dx *= way;
    dy *= way;
    const double one = 1 << bits;
    const Three start = dy * x - dx * y;
    const Three right = -dy * one;
    const Three down = dx * one;
    // Centers on an edge that runs down, or level to the right, are inside, others not: below 1/2 means at most 0.
    const Three least_inside = (Three)((dy * 0x1p33 + dx <= 0) & (ThreeLongs)(Three{} + 0.5));

    // Nearness is linear in the picture: that of corner 0 and shares of the differences to the others.
    const double share = way / area;
    const double origin = piece.nearness[0];
    const double to_b = (piece.nearness[1] - origin) * share;
    const double to_c = (piece.nearness[2] - origin) * share;
    const auto low = static_cast<std::int64_t>(~piece.face & 0xFFFFFFFFU);

    Doubles ramp;
    for (int lane = 0; lane < lanes; ++lane)
        ramp[lane] = lane;
    Doubles row_a = all_of(start[0]) + ramp * right[0];
    Doubles row_b = all_of(start[1]) + ramp * right[1];
    Doubles row_c = all_of(start[2]) + ramp * right[2];
    std::uint64_t* row = keys + std::ptrdiff_t{first_y - tile_y} * tile_stride + (first_x - tile_x);
    for (int rows = last_y - first_y; rows >= 0; --rows, row += tile_stride)
    {
        Doubles at_a = row_a;
        Doubles at_b = row_b;
        Doubles at_c = row_c;
        for (int i = 0; i <= last_x - first_x; i += lanes)
        {
            const Longs inside = (at_a >= least_inside[0]) & (at_b >= least_inside[1]) & (at_c >= least_inside[2]);
            const Doubles nearness = origin + (at_b * to_b + at_c * to_c);
            const Longs key = (__builtin_convertvector((Ints) __builtin_convertvector(nearness, Floats), Longs) << 32) | low;
            LooseLongs* place = reinterpret_cast<LooseLongs*>(row + i);
            const Longs seen = *place;
            const Longs nearer = (key > seen) & inside;
            *place = (key & nearer) | (seen & ~nearer);
            at_a += lanes * right[0];
            at_b += lanes * right[1];
            at_c += lanes * right[2];
        }
        row_a += down[0];
        row_b += down[1];
        row_c += down[2];
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
#endif

const TileKernel* FRESCO_KERNEL()
{
#if FRESCO_VECTOR_BYTES > 0
    static constexpr TileKernel kernel{FRESCO_KERNEL_NAME, draw};
    return &kernel;
#else
    return nullptr;
#endif
}

}  // namespace fresco::rendering
