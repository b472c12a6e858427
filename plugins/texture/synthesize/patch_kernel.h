#pragma once

#include <cstddef>
#include <cstdint>

/// \file The inner loops of the search, compiled for several kinds of processors from patch_kernel.inl. patch_kernel() in
/// search.h chooses the fastest one that runs here; nothing else calls them.

namespace fresco::synthesize
{

/// The inner loops of the search for one kind of processor.
struct PatchKernel
{
    const char* name;
    std::size_t rows;     ///< Queries compared at once.
    std::size_t columns;  ///< Keys of a panel.

    /// Products of `rows` queries (`inner` values each, one after another) with a panel of keys (inner x columns), compared with
    /// the least so far of each query and column. A smaller product replaces it, and `where` gets the panel's number.
    /// `least`, `where`: rows x columns.
    void (*compare)(const float* queries, const float* panel, std::size_t inner, std::int32_t number, float* least,
                    std::int32_t* where);

    /// Sum of squared differences of `rows` rows of `length` values; b's rows are `b_stride` apart, a's lie one after another.
    /// Exact for at most 127 values a row that differ by less than 4096.
    float (*squared_distance)(const std::int16_t* a, const std::int16_t* b, std::size_t b_stride, std::size_t rows,
                              std::size_t length);
};

/// For any processor, and for x86-64 ones with AVX2 and FMA, and with AVX-512; null where the compiler cannot make them.
const PatchKernel* base_kernel();
const PatchKernel* avx2_kernel();
const PatchKernel* avx512_kernel();

}  // namespace fresco::synthesize
