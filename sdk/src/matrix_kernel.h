#pragma once

#include <cstddef>

namespace fresco::matrix
{

/// The inner loop of multiply_matrices for one kind of processor.
struct Kernel
{
    const char* name;
    std::size_t rows;     ///< Of c at once: a comes in panels of so many rows, …
    std::size_t columns;  ///< … b in panels of so many columns.

    /// c (rows x columns, `stride` apart) += a (inner x rows) b (inner x columns).
    void (*multiply)(const float* a, const float* b, std::size_t inner, float* c, std::size_t stride);
};

/// For any processor, and for x86-64 ones with AVX2 and FMA, and with AVX-512; null where the compiler cannot make them.
const Kernel* base_kernel();
const Kernel* avx2_kernel();
const Kernel* avx512_kernel();
/// The fastest that this processor can run.
const Kernel& fastest_kernel();

}  // namespace fresco::matrix
