// The loops of winograd_kernel.h with vectors of FRESCO_VECTOR_BYTES. Compiled several times for other processors, so that it
// must not use anything inline from elsewhere: the linker might take this copy for all.

#include "winograd_kernel.h"

namespace winograd
{
#if FRESCO_VECTOR_BYTES > 0
namespace
{

constexpr int lanes = FRESCO_VECTOR_BYTES / 4;
constexpr int tile_rows = 6;
constexpr int panel_vectors = FRESCO_VECTOR_BYTES == 64 ? 4 : 2;

typedef float Vector __attribute__((vector_size(lanes * 4), aligned(4), may_alias));
typedef std::int8_t Bytes __attribute__((vector_size(lanes), aligned(1), may_alias));
typedef std::int16_t Shorts __attribute__((vector_size(lanes * 2)));
typedef std::int32_t Numbers __attribute__((vector_size(lanes * 4)));

// By way of Shorts: at once, GCC 12 does it one by one.
inline Numbers wide_of(Bytes bytes)
{
    return __builtin_convertvector(__builtin_convertvector(bytes, Shorts), Numbers);
}

inline Bytes narrow_of(Numbers numbers)
{
    return __builtin_convertvector(__builtin_convertvector(numbers, Shorts), Bytes);
}

inline Vector load(const float* values)
{
    return *reinterpret_cast<const Vector*>(values);
}

inline void store(float* values, Vector vector)
{
    *reinterpret_cast<Vector*>(values) = vector;
}

constexpr int side = 6;         ///< Outputs along a tile's side.
constexpr int wide = side + 2;  ///< Inputs along it.

/// Rows of Bᵀ.
inline void eight_from_eight(const Vector* in, int step, Vector* out)
{
    const Vector d1 = in[step], d2 = in[2 * step], d3 = in[3 * step], d4 = in[4 * step], d5 = in[5 * step], d6 = in[6 * step];
    const Vector even = d2 - 4.25F * d4 + d6;
    const Vector odd = d1 - 4.25F * d3 + d5;
    const Vector even_two = 0.0625F * d2 - 0.3125F * d4 + 0.25F * d6;
    const Vector odd_two = 0.125F * d1 - 0.625F * d3 + 0.5F * d5;
    const Vector even_half = 16 * d2 - 20 * d4 + 4 * d6;
    const Vector odd_half = 8 * d1 - 10 * d3 + 2 * d5;
    out[0] = in[0] - d6 + 5.25F * (d4 - d2);
    out[1] = even + odd;
    out[2] = even - odd;
    out[3] = even_two + odd_two;
    out[4] = even_two - odd_two;
    out[5] = even_half + odd_half;
    out[6] = even_half - odd_half;
    out[7] = in[7 * step] - d1 + 5.25F * (d3 - d5);
}

/// Rows of Aᵀ.
inline void six_from_eight(const Vector* in, int step, Vector* out)
{
    const Vector sum = in[step] + in[2 * step];
    const Vector difference = in[step] - in[2 * step];
    const Vector sum_two = in[3 * step] + in[4 * step];
    const Vector difference_two = in[3 * step] - in[4 * step];
    const Vector sum_half = in[5 * step] + in[6 * step];
    const Vector difference_half = in[5 * step] - in[6 * step];
    out[0] = in[0] + sum + sum_two + sum_half;
    out[1] = difference + 2 * difference_two + 0.5F * difference_half;
    out[2] = sum + 4 * sum_two + 0.25F * sum_half;
    out[3] = difference + 8 * difference_two + 0.125F * difference_half;
    out[4] = sum + 16 * sum_two + 0.0625F * sum_half;
    out[5] = difference + 32 * difference_two + 0.03125F * difference_half + in[7 * step];
}

/// load(pixel): its values of `lanes` channels.
template <class Load>
inline void transform_tile(const Load& load, float* out, std::size_t stride)
{
    Vector half[wide * wide];
    for (int x = 0; x < wide; ++x)
    {
        Vector column[wide];
        for (int y = 0; y < wide; ++y)
            column[y] = load(wide * y + x);
        eight_from_eight(column, 1, half + wide * x);
    }
    for (int y = 0; y < wide; ++y)
    {
        Vector row[wide];
        eight_from_eight(half + y, wide, row);
        for (int x = 0; x < wide; ++x)
            store(out + static_cast<std::size_t>(wide * y + x) * stride, row[x]);
    }
}

/// Brings near what a tile has beyond the one to its left. A pixel's channels are short runs far from the next row's: the
/// processor does not foresee them.
template <class Value>
inline void bring_near(const Value* const* pixels, int channel)
{
    for (int i = 0; i < wide * wide; ++i)
        if (i % wide >= 2)
            __builtin_prefetch(pixels[i] + channel);
}

void transform(const float* const* pixels, const float* const* next, int channels, float* out, std::size_t stride)
{
    for (int channel = 0; channel < channels; channel += lanes)
    {
        bring_near(next, channel);
        transform_tile([&](int i) { return load(pixels[i] + channel); }, out + channel, stride);
    }
}

/// `values` where the byte is `number`, else 0.
inline Vector where(const std::uint8_t* bytes, std::uint8_t number, Vector values)
{
    const auto is = wide_of(*reinterpret_cast<const Bytes*>(bytes)) == number;
    return is ? values : Vector{};
}

void transform_gradient(const GradientTile& tile, const GradientTile& next, bool own, int channels, float* out,
                        std::size_t stride)
{
    for (int channel = 0; channel < channels; channel += lanes)
    {
        bring_near(next.next, channel);
        if (channel % 64 == 0)
            bring_near(next.chosen, channel);
        const auto of_next = [&](int i)
        { return where(tile.chosen[i] + channel, tile.number[i], load(tile.next[i] + channel)); };
        if (!own)
        {
            transform_tile(of_next, out + channel, stride);
            continue;
        }
        bring_near(next.own, channel);
        transform_tile([&](int i) { return of_next(i) + where(tile.mask[i] + channel, 1, load(tile.own[i] + channel)); },
                       out + channel, stride);
    }
}

template <int vectors>
void blocks(const float* values, int tiles, int step, int inner, const float* filters, float* products)
{
    for (int tile = 0; tile < tiles; tile += tile_rows)
    {
        // One by one: as an aggregate they would be cleared in memory too.
        Vector sums[tile_rows][vectors];
        for (int row = 0; row < tile_rows; ++row)
            for (int v = 0; v < vectors; ++v)
                sums[row][v] = Vector{};
        // Rows lie side by side where that counts: of many channels, which do not stay in the first-level cache.
        const float* next = values + (tile + tile_rows) * step;
        for (int k = 0; k < inner; ++k)
        {
            __builtin_prefetch(next + k * tile_rows);
            Vector of_panel[vectors];
            for (int v = 0; v < vectors; ++v)
                of_panel[v] = load(filters + (k * vectors + v) * lanes);
            for (int row = 0; row < tile_rows; ++row)
            {
                const float value = values[(tile + row) * step + k];
                for (int v = 0; v < vectors; ++v)
                    sums[row][v] += of_panel[v] * value;
            }
        }
        for (int row = 0; row < tile_rows; ++row)
            for (int v = 0; v < vectors; ++v)
                store(products + ((tile + row) * vectors + v) * lanes, sums[row][v]);
    }
}

void multiply(const float* values, int tiles, int step, int inner, const float* filters, int outputs, float* products)
{
    switch (outputs / lanes)
    {
    case 1:
        return blocks<1>(values, tiles, step, inner, filters, products);
    case 2:
        return blocks<2>(values, tiles, step, inner, filters, products);
    case 3:
        return blocks<3>(values, tiles, step, inner, filters, products);
    default:
        return blocks<panel_vectors>(values, tiles, step, inner, filters, products);
    }
}

/// Calls write(pixel, vector) for the outputs of `lanes` channels.
template <class Write>
inline void each_output(const float* in, std::size_t stride, const Write& write)
{
    Vector half[side * wide];
    for (int x = 0; x < wide; ++x)
    {
        Vector column[wide];
        for (int y = 0; y < wide; ++y)
            column[y] = load(in + static_cast<std::size_t>(wide * y + x) * stride);
        six_from_eight(column, 1, half + side * x);
    }
    for (int y = 0; y < side; ++y)
    {
        Vector row[side];
        six_from_eight(half + y, side, row);
        for (int x = 0; x < side; ++x)
            write(side * y + x, row[x]);
    }
}

void transform_back(const float* in, std::size_t stride, int channels, const float* bias, float* const* pixels,
                    std::uint8_t* const* masks)
{
    for (int channel = 0; channel < channels; channel += lanes)
        each_output(in + channel, stride,
                    [&](int i, Vector value)
                    {
                        if (pixels[i] == nullptr)
                            return;
                        if (bias == nullptr)
                            return store(pixels[i] + channel, value);
                        const Vector response = value + load(bias + channel);
                        // NaN is passed on, as in libtorch: the optimizer has to see it.
                        const auto off = response <= 0;
                        store(pixels[i] + channel, off ? Vector{} : response);
                        if (masks != nullptr)
                            *reinterpret_cast<Bytes*>(masks[i] + channel) = narrow_of(~off & 1);
                    });
}

/// The second where it is larger or not a number.
inline bool goes_first(float b, float a)
{
    return b > a || b != b;
}

inline float larger(float a, float b)
{
    return goes_first(b, a) ? b : a;
}

void pool(const float* const* pixels, int channels, float* out, std::uint8_t* chosen)
{
    const float* a = pixels[0];
    const float* b = pixels[1];
    const float* c = pixels[2];
    const float* d = pixels[3];
    for (int i = 0; i < channels; ++i)
        out[i] = larger(larger(a[i], b[i]), larger(c[i], d[i]));
    for (int i = 0; chosen != nullptr && i < channels; ++i)
    {
        const int upper = goes_first(b[i], a[i]) ? 1 : 0;
        const int lower = goes_first(d[i], c[i]) ? 3 : 2;
        const bool below = goes_first(larger(c[i], d[i]), larger(a[i], b[i]));
        chosen[i] = static_cast<std::uint8_t>(out[i] == 0 ? 4 : below ? lower : upper);
    }
}

}  // namespace
#endif

const Kernel* FRESCO_KERNEL()
{
#if FRESCO_VECTOR_BYTES > 0
    static constexpr Kernel kernel{FRESCO_KERNEL_NAME, panel_vectors * lanes, tile_rows, transform, transform_gradient,
                                   multiply,           transform_back,        pool};
    return &kernel;
#else
    return nullptr;
#endif
}

}  // namespace winograd
