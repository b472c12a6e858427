#pragma once

#include <cstddef>
#include <cstdint>

namespace winograd
{

/// The 64 pixels of a tile of a gradient, row by row: of `next` where `chosen` is `number`, plus of `own` where `mask` is 1.
struct GradientTile
{
    const float* next[64];
    const std::uint8_t* chosen[64];
    std::uint8_t number[64];
    const float* own[64];
    const std::uint8_t* mask[64];
};

/// The inner loops for one kind of processor: of the minimal filtering F(6x6, 3x3) (Winograd 1980; Lavin and Gray, CVPR 2016,
/// section 4.1), with the points 0, ±1, ±2, ±1/2 and infinity, and of the operations between two convolutions. A tile of 8 x 8
/// inputs becomes 64 transformed values, each multiplied with the filter's at the same position, and these become 6 x 6 outputs:
/// a fifth of the direct way's multiplications. Channels are innermost and multiples of 16.
struct Kernel
{
    const char* name;
    int panel;  ///< Outputs that lie side by side in packed filters.
    int rows;   ///< Tiles are multiplied so many at once.

    /// 64 pixels, row by row, each with `channels` values -> out[position * stride + channel]. `next`: those of the tile to the
    /// right, which are brought near.
    void (*transform)(const float* const* pixels, const float* const* next, int channels, float* out, std::size_t stride);

    /// Transforms a gradient, adding the values of `next`; `own`: the gradient has values of its own.
    void (*transform_gradient)(const GradientTile& tile, const GradientTile& next, bool own, int channels, float* out,
                               std::size_t stride);

    /// Products for one position and panel: the first `inner` of each tile's `step` values by filters (inner x outputs) -> tiles
    /// x outputs. `tiles` is a multiple of `rows`; `outputs` is `panel`, or a smaller multiple of 16.
    void (*multiply)(const float* values, int tiles, int step, int inner, const float* filters, int outputs, float* products);

    /// in[position * stride + channel] -> 36 pixels; null pixels are left out. Unless `bias` is null, that is added and the sum
    /// is rectified; masks become 1 where it is positive. `masks` may be null.
    void (*transform_back)(const float* in, std::size_t stride, int channels, const float* bias, float* const* pixels,
                           std::uint8_t* const* masks);

    /// The largest of four pixels; `chosen`, unless null: which of them, the first of equal ones, or 4 where that is 0.
    void (*pool)(const float* const* pixels, int channels, float* out, std::uint8_t* chosen);
};

/// For any processor, and for x86-64 ones with AVX2 and FMA, and with AVX-512; null where the compiler cannot make them.
const Kernel* base_kernel();
const Kernel* avx2_kernel();
const Kernel* avx512_kernel();

}  // namespace winograd
