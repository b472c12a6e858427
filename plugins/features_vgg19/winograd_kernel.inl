// The loops of winograd_kernel.h with vectors of FRESCO_LANES floats. Compiled several times for other processors, so that it
// must not use anything inline from elsewhere: the linker might take this copy for all.

#include "winograd_kernel.h"

namespace winograd
{
namespace
{

constexpr int lanes = FRESCO_LANES;
constexpr int tile_rows = 6;
constexpr int panel_vectors = FRESCO_PANEL_VECTORS;

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

/// Rows of Bᵀ.
inline void six_from_six(const Vector* in, int step, Vector* out)
{
    const Vector d0 = in[0], d1 = in[step], d2 = in[2 * step], d3 = in[3 * step], d4 = in[4 * step], d5 = in[5 * step];
    const Vector even = d4 - 4 * d2;
    const Vector odd = d3 - 4 * d1;
    const Vector even_half = d4 - d2;
    const Vector odd_twice = 2 * (d3 - d1);
    out[0] = 4 * d0 - 5 * d2 + d4;
    out[1] = even + odd;
    out[2] = even - odd;
    out[3] = even_half + odd_twice;
    out[4] = even_half - odd_twice;
    out[5] = 4 * d1 - 5 * d3 + d5;
}

/// Rows of Aᵀ.
inline void four_from_six(const Vector* in, int step, Vector* out)
{
    const Vector sum = in[step] + in[2 * step];
    const Vector difference = in[step] - in[2 * step];
    const Vector outer_sum = in[3 * step] + in[4 * step];
    const Vector outer_difference = in[3 * step] - in[4 * step];
    out[0] = in[0] + sum + outer_sum;
    out[1] = difference + 2 * outer_difference;
    out[2] = sum + 4 * outer_sum;
    out[3] = difference + 8 * outer_difference + in[5 * step];
}

void transform(const float* const* pixels, int channels, float* out, std::size_t stride)
{
    for (int channel = 0; channel < channels; channel += lanes)
    {
        Vector tile[36];
        Vector half[36];
        for (int i = 0; i < 36; ++i)
            tile[i] = load(pixels[i] + channel);
        for (int x = 0; x < 6; ++x)
            six_from_six(tile + x, 6, half + 6 * x);
        for (int y = 0; y < 6; ++y)
        {
            Vector row[6];
            six_from_six(half + y, 6, row);
            for (int x = 0; x < 6; ++x)
                store(out + static_cast<std::size_t>(6 * y + x) * stride + channel, row[x]);
        }
    }
}

template <int vectors>
inline void block(const float* values, int inner, const float* panel, float* products, std::size_t outputs)
{
    Vector sums[tile_rows][vectors] = {};
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

/// Calls write(pixel, vector) for the 16 outputs of `lanes` channels.
template <class Write>
inline void each_output(const float* in, std::size_t stride, const Write& write)
{
    Vector half[24];
    for (int x = 0; x < 6; ++x)
    {
        Vector column[6];
        for (int y = 0; y < 6; ++y)
            column[y] = load(in + static_cast<std::size_t>(6 * y + x) * stride);
        four_from_six(column, 1, half + 4 * x);
    }
    for (int y = 0; y < 4; ++y)
    {
        Vector row[4];
        four_from_six(half + y, 4, row);
        for (int x = 0; x < 4; ++x)
            write(4 * y + x, row[x]);
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
                        // What is not a number goes on, as in libtorch: the optimiser has to see it.
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

const Kernel* FRESCO_KERNEL()
{
    static constexpr Kernel kernel{FRESCO_KERNEL_NAME, panel_vectors * lanes, tile_rows, transform, multiply,
                                   transform_back,     rectify_back,          pool,      unpool,    mask_sum};
    return &kernel;
}

}  // namespace winograd
