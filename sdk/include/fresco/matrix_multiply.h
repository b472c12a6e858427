#pragma once

#include <cstddef>

namespace fresco
{

/// A float32 matrix in somebody's memory: element (row, column) is values[row * row_stride + column * column_stride].
struct MatrixView
{
    const float* values = nullptr;
    std::size_t rows = 0;
    std::size_t columns = 0;
    std::ptrdiff_t row_stride = 0;
    std::ptrdiff_t column_stride = 0;
};

/// c (rows of a x columns of b, row-major) = a b, in blocks that fit the caches (Goto and van de Geijn, "Anatomy of
/// high-performance matrix multiplication", 2008), with the widest vectors that this processor has. Long sums are cut into pieces
/// that depend only on the shapes and added in order: equal bytes for any number of threads. Throws std::invalid_argument where
/// the shapes do not fit.
void multiply_matrices(const MatrixView& a, const MatrixView& b, float* c, int threads);

}  // namespace fresco
