#pragma once

#include <cstddef>

namespace fresco::matrix
{

/// The inner loop of multiply_matrices for one kind of processor.
struct Kernel
{
    const char* name;
    std::size_t rows;     ///< Rows of c at once.
    std::size_t columns;  ///< Columns of c at once.

    /// c (rows x columns, `stride` from row to row) += a b. `a`: where each of the rows begins; its elements are `a_step` apart.
    /// b: `columns` elements side by side, `b_step` from one row to the next.
    void (*multiply)(const float* const* a, std::ptrdiff_t a_step, const float* b, std::ptrdiff_t b_step, std::size_t inner,
                     float* c, std::size_t stride);
};

/// For any processor, and for x86-64 ones with AVX2 and FMA, and with AVX-512; null where the compiler cannot make them.
const Kernel* base_kernel();
const Kernel* avx2_kernel();
const Kernel* avx512_kernel();
/// The fastest that this processor can run.
const Kernel& fastest_kernel();

}  // namespace fresco::matrix
