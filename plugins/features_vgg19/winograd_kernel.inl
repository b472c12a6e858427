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
constexpr int turned_rows = 2 * panel_vectors;

typedef float Vector __attribute__((vector_size(lanes * 4), aligned(4), may_alias));
typedef std::int8_t Bytes __attribute__((vector_size(lanes), aligned(1), may_alias));

inline Vector load(const float* values)
{
    return *reinterpret_cast<const Vector*>(values);
}

inline void store(float* values, Vector vector)
{
    *reinterpret_cast<Vector*>(values) = vector;
}

constexpr int side = 6;         ///< Of a tile's outputs.
constexpr int wide = side + 2;  ///< Of its inputs.

/// Rows of Bᵀ. The points are 0, ±1, ±2, ±1/2 and infinity: reversing a filter takes each to its reciprocal, which is among them.
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

void transform(const float* const* pixels, const float* const* next, int channels, float* out, std::size_t stride)
{
    for (int channel = 0; channel < channels; channel += lanes)
    {
        // A pixel's channels are short runs far from the next row's: the processor does not foresee them.
        for (int i = 0; i < wide * wide; ++i)
            if (i % wide >= 2)
                __builtin_prefetch(next[i] + channel);
        Vector tile[wide * wide];
        Vector half[wide * wide];
        for (int i = 0; i < wide * wide; ++i)
            tile[i] = load(pixels[i] + channel);
        for (int x = 0; x < wide; ++x)
            eight_from_eight(tile + x, wide, half + wide * x);
        for (int y = 0; y < wide; ++y)
        {
            Vector row[wide];
            eight_from_eight(half + y, wide, row);
            for (int x = 0; x < wide; ++x)
                store(out + static_cast<std::size_t>(wide * y + x) * stride + channel, row[x]);
        }
    }
}

template <int vectors>
inline void block(const float* values, int inner, const float* panel, float* products, std::size_t outputs)
{
    // One by one: as an aggregate they would be cleared in memory too.
    Vector sums[tile_rows][vectors];
    for (int row = 0; row < tile_rows; ++row)
        for (int v = 0; v < vectors; ++v)
            sums[row][v] = Vector{};
    for (int k = 0; k < inner; ++k)
    {
        Vector filters[vectors];
        for (int v = 0; v < vectors; ++v)
            filters[v] = load(panel + (k * vectors + v) * lanes);
        for (int row = 0; row < tile_rows; ++row)
        {
            const float value = values[row * inner + k];
            for (int v = 0; v < vectors; ++v)
                sums[row][v] += filters[v] * value;
        }
    }
    for (int row = 0; row < tile_rows; ++row)
        for (int v = 0; v < vectors; ++v)
            store(products + static_cast<std::size_t>(row) * outputs + v * lanes, sums[row][v]);
}

template <int vectors>
inline void blocks(const float* values, int tiles, int inner, const float* panel, float* products, int outputs)
{
    for (int tile = 0; tile < tiles; tile += tile_rows)
        block<vectors>(values + static_cast<std::size_t>(tile) * inner, inner, panel,
                       products + static_cast<std::size_t>(tile) * outputs, outputs);
}

void multiply(const float* values, int tiles, int inner, const float* filters, int outputs, float* products)
{
    constexpr int panel = panel_vectors * lanes;
    int output = 0;
    for (; output + panel <= outputs; output += panel)
        blocks<panel_vectors>(values, tiles, inner, filters + static_cast<std::size_t>(output) * inner, products + output,
                              outputs);
    const float* rest = filters + static_cast<std::size_t>(output) * inner;
    switch ((outputs - output) / lanes)
    {
    case 1:
        blocks<1>(values, tiles, inner, rest, products + output, outputs);
        break;
    case 2:
        blocks<2>(values, tiles, inner, rest, products + output, outputs);
        break;
    case 3:
        blocks<3>(values, tiles, inner, rest, products + output, outputs);
        break;
    default:
        break;
    }
}

#if defined(__clang__) || __GNUC__ >= 12
template <int... i>
struct Numbers
{
    /// The first halves of a and b, element by element in turn, …
    static Vector lower(Vector a, Vector b) { return __builtin_shufflevector(a, b, (i / 2 + i % 2 * lanes)...); }
    /// … and the second halves.
    static Vector upper(Vector a, Vector b) { return __builtin_shufflevector(a, b, (lanes / 2 + i / 2 + i % 2 * lanes)...); }
};
template <int count, int... rest>
struct NumbersTo : NumbersTo<count - 1, count - 1, rest...>
{
};
template <int... all>
struct NumbersTo<0, all...> : Numbers<all...>
{
};

/// lanes x lanes values, transposed: as many rounds of merging the lower and the upper rows as the number of rows has bits.
inline void transpose_square(const float* in, std::size_t in_stride, float* out, std::size_t out_stride)
{
    Vector rows[lanes];
    for (int i = 0; i < lanes; ++i)
        rows[i] = load(in + static_cast<std::size_t>(i) * in_stride);
    for (int round = 1; round < lanes; round *= 2)
    {
        Vector merged[lanes];
        for (int i = 0; i < lanes / 2; ++i)
        {
            merged[2 * i] = NumbersTo<lanes>::lower(rows[i], rows[i + lanes / 2]);
            merged[2 * i + 1] = NumbersTo<lanes>::upper(rows[i], rows[i + lanes / 2]);
        }
        for (int i = 0; i < lanes; ++i)
            rows[i] = merged[i];
    }
    for (int i = 0; i < lanes; ++i)
        store(out + static_cast<std::size_t>(i) * out_stride, rows[i]);
}
#else
inline void transpose_square(const float* in, std::size_t in_stride, float* out, std::size_t out_stride)
{
    for (int i = 0; i < lanes; ++i)
        for (int j = 0; j < lanes; ++j)
            out[static_cast<std::size_t>(j) * out_stride + i] = in[static_cast<std::size_t>(i) * in_stride + j];
}
#endif

/// Both extents are multiples of `lanes`; rows lie side by side.
inline void transpose(const float* in, int rows, int columns, float* out)
{
    for (int row = 0; row < rows; row += lanes)
        for (int column = 0; column < columns; column += lanes)
            transpose_square(in + static_cast<std::size_t>(row) * columns + column, columns,
                             out + static_cast<std::size_t>(column) * rows + row, rows);
}

/// For `vectors` of tiles, adds one panel's terms to the sums of `turned_rows` of the filters' inputs. `rows`: their filters.
template <int vectors>
inline void turned_block(const float* values, int tiles, const float* rows, int width, bool first, float* products)
{
    Vector sums[turned_rows][vectors];
    for (int row = 0; row < turned_rows; ++row)
        for (int v = 0; v < vectors; ++v)
            sums[row][v] = first ? Vector{} : load(products + static_cast<std::size_t>(row) * tiles + v * lanes);
    for (int k = 0; k < width; ++k)
    {
        Vector of_tiles[vectors];
        for (int v = 0; v < vectors; ++v)
            of_tiles[v] = load(values + static_cast<std::size_t>(k) * tiles + v * lanes);
        for (int row = 0; row < turned_rows; ++row)
        {
            const float filter = rows[row * width + k];
            for (int v = 0; v < vectors; ++v)
                sums[row][v] += of_tiles[v] * filter;
        }
    }
    for (int row = 0; row < turned_rows; ++row)
        for (int v = 0; v < vectors; ++v)
            store(products + static_cast<std::size_t>(row) * tiles + v * lanes, sums[row][v]);
}

/// Tiles lie side by side here. Panel by panel, so that the filters are read in their order, each once.
void multiply_turned(const float* values, int tiles, int inner, const float* filters, int outputs, float* scratch,
                     float* products)
{
    constexpr int panel = panel_vectors * lanes;
    float* sums = scratch + static_cast<std::size_t>(inner) * tiles;
    transpose(values, tiles, inner, scratch);
    for (int first = 0; first < inner; first += panel)
    {
        const int width = inner - first < panel ? inner - first : panel;
        const float* of_panel = scratch + static_cast<std::size_t>(first) * tiles;
        for (int output = 0; output < outputs; output += turned_rows)
        {
            const float* rows = filters + static_cast<std::size_t>(first) * outputs + static_cast<std::size_t>(output) * width;
            float* to = sums + static_cast<std::size_t>(output) * tiles;
            for (int tile = 0; tile < tiles; tile += 3 * lanes)
                switch ((tiles - tile) / lanes)
                {
                case 1:
                    turned_block<1>(of_panel + tile, tiles, rows, width, first == 0, to + tile);
                    break;
                case 2:
                    turned_block<2>(of_panel + tile, tiles, rows, width, first == 0, to + tile);
                    break;
                default:
                    turned_block<3>(of_panel + tile, tiles, rows, width, first == 0, to + tile);
                    break;
                }
        }
    }
    transpose(sums, outputs, tiles, products);
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

void transform_back(const float* in, std::size_t stride, int channels, float* const* pixels)
{
    for (int channel = 0; channel < channels; channel += lanes)
        each_output(in + channel, stride,
                    [&](int i, Vector value)
                    {
                        if (pixels[i] != nullptr)
                            store(pixels[i] + channel, value);
                    });
}

void rectify_back(const float* in, std::size_t stride, int channels, const float* bias, float* const* pixels,
                  std::uint8_t* const* masks)
{
    for (int channel = 0; channel < channels; channel += lanes)
    {
        const Vector offset = load(bias + channel);
        each_output(in + channel, stride,
                    [&](int i, Vector value)
                    {
                        if (pixels[i] == nullptr)
                            return;
                        const Vector response = value + offset;
                        // What is not a number goes on, as in libtorch: the optimizer has to see it.
                        const auto off = response <= 0;
                        store(pixels[i] + channel, off ? Vector{} : response);
                        if (masks != nullptr)
                            *reinterpret_cast<Bytes*>(masks[i] + channel) = __builtin_convertvector(~off & 1, Bytes);
                    });
    }
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

void pool(const float* upper, const float* lower, int channels, float* out, std::uint8_t* chosen)
{
    for (int c = 0; c < channels; ++c)
        out[c] = larger(larger(upper[c], upper[c + channels]), larger(lower[c], lower[c + channels]));
    if (chosen == nullptr)
        return;
    for (int c = 0; c < channels; ++c)
    {
        const int left = goes_first(upper[c + channels], upper[c]) ? 1 : 0;
        const int right = goes_first(lower[c + channels], lower[c]) ? 3 : 2;
        const bool below = goes_first(larger(lower[c], lower[c + channels]), larger(upper[c], upper[c + channels]));
        chosen[c] = static_cast<std::uint8_t>(below ? right : left);
    }
}

void unpool(const float* from, const std::uint8_t* chosen, std::uint8_t number, int channels, float* out)
{
    for (int c = 0; c < channels; ++c)
        out[c] = chosen[c] == number ? from[c] : 0.0F;
}

void mask_sum(const float* a, const float* b, const std::uint8_t* mask, std::size_t count, float* out)
{
    if (a != nullptr && b != nullptr)
        for (std::size_t i = 0; i < count; ++i)
        {
            const float sum = a[i] + b[i];
            out[i] = mask[i] != 0 ? sum : 0.0F;
        }
    else
    {
        const float* only = a != nullptr ? a : b;
        for (std::size_t i = 0; i < count; ++i)
        {
            const float value = only[i];
            out[i] = mask[i] != 0 ? value : 0.0F;
        }
    }
}

}  // namespace
#endif

const Kernel* FRESCO_KERNEL()
{
#if FRESCO_VECTOR_BYTES > 0
    static constexpr Kernel kernel{FRESCO_KERNEL_NAME, panel_vectors * lanes, tile_rows,    lanes, transform, multiply,
                                   multiply_turned,    transform_back,        rectify_back, pool,  unpool,    mask_sum};
    return &kernel;
#else
    return nullptr;
#endif
}

}  // namespace winograd
