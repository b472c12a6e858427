#include <fresco/matrix_multiply.h>
#include <fresco/parallel.h>

#include "matrix_kernel.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace fresco
{
namespace
{

// A block of b (inner x columns) stays in the second-level cache while the rows of a pass by it, a block of a beside it.
constexpr std::size_t block_inner = 256;
constexpr std::size_t block_rows = 96;
constexpr std::size_t block_columns = 256;
// Terms of one piece of a long sum: enough work for a thread, few enough to lose no digit that matters.
constexpr std::size_t piece_inner = 8192;

struct Range
{
    std::size_t begin = 0;
    std::size_t end = 0;

    std::size_t size() const { return end - begin; }
};

Range block_of(std::size_t number, std::size_t size, std::size_t count)
{
    return {number * size, std::min(count, (number + 1) * size)};
}

std::size_t blocks(std::size_t count, std::size_t size)
{
    return (count + size - 1) / size;
}

/// Copies vectors of a matrix into panels: `width` vectors side by side, element by element; missing ones are zero.
void pack(const float* values, std::ptrdiff_t vector_stride, std::ptrdiff_t element_stride, std::size_t vectors,
          std::size_t elements, std::size_t width, float* panels)
{
    for (std::size_t first = 0; first < vectors; first += width)
    {
        const std::size_t there = std::min(width, vectors - first);
        const float* from = values + static_cast<std::ptrdiff_t>(first) * vector_stride;
        float* panel = panels + first * elements;
        if (there < width)
            std::fill_n(panel, width * elements, 0.0F);
        if (vector_stride == 1)
            for (std::size_t e = 0; e < elements; ++e)
                std::copy_n(from + static_cast<std::ptrdiff_t>(e) * element_stride, there, panel + e * width);
        else
            for (std::size_t v = 0; v < there; ++v)
                for (std::size_t e = 0; e < elements; ++e)
                    panel[e * width + v] =
                        from[static_cast<std::ptrdiff_t>(v) * vector_stride + static_cast<std::ptrdiff_t>(e) * element_stride];
    }
}

const float* element(const MatrixView& matrix, std::size_t row, std::size_t column)
{
    return matrix.values + static_cast<std::ptrdiff_t>(row) * matrix.row_stride +
           static_cast<std::ptrdiff_t>(column) * matrix.column_stride;
}

/// The part of the product for some rows, columns and terms.
class Block
{
  public:
    Block(const MatrixView& a, const MatrixView& b, Range rows, Range columns) : a_(a), b_(b), rows_(rows), columns_(columns)
    {
        const std::size_t full_rows = blocks(rows.size(), kernel_.rows) * kernel_.rows;
        stride_ = blocks(columns.size(), kernel_.columns) * kernel_.columns;
        sums_.assign(full_rows * stride_, 0.0F);
        packed_a_.resize(full_rows * block_inner);
        packed_b_.resize(stride_ * block_inner);
    }

    void add(Range inner)
    {
        for (std::size_t k = inner.begin; k < inner.end; k += block_inner)
            add_block({k, std::min(inner.end, k + block_inner)});
    }

    void write(float* c, std::size_t stride) const
    {
        for (std::size_t row = 0; row < rows_.size(); ++row)
            std::copy_n(sums_.data() + row * stride_, columns_.size(), c + (rows_.begin + row) * stride + columns_.begin);
    }

  private:
    void add_block(Range inner)
    {
        pack(element(a_, rows_.begin, inner.begin), a_.row_stride, a_.column_stride, rows_.size(), inner.size(), kernel_.rows,
             packed_a_.data());
        pack(element(b_, inner.begin, columns_.begin), b_.column_stride, b_.row_stride, columns_.size(), inner.size(),
             kernel_.columns, packed_b_.data());
        for (std::size_t column = 0; column < columns_.size(); column += kernel_.columns)
            for (std::size_t row = 0; row < rows_.size(); row += kernel_.rows)
                kernel_.multiply(packed_a_.data() + row * inner.size(), packed_b_.data() + column * inner.size(), inner.size(),
                                 sums_.data() + row * stride_ + column, stride_);
    }

    const matrix::Kernel& kernel_ = matrix::fastest_kernel();
    const MatrixView& a_;
    const MatrixView& b_;
    Range rows_;
    Range columns_;
    std::size_t stride_ = 0;
    std::vector<float> sums_;
    std::vector<float> packed_a_;
    std::vector<float> packed_b_;
};

}  // namespace

const matrix::Kernel& matrix::fastest_kernel()
{
    static const Kernel& fastest = []() -> const Kernel&
    {
#if defined(__x86_64__)
        if (avx512_kernel() != nullptr && __builtin_cpu_supports("avx512f") != 0)
            return *avx512_kernel();
        if (avx2_kernel() != nullptr && __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0)
            return *avx2_kernel();
#endif
        return *base_kernel();
    }();
    return fastest;
}

void multiply_matrices(const MatrixView& a, const MatrixView& b, float* c, int threads)
{
    if (a.columns != b.rows)
        throw std::invalid_argument("multiply_matrices: a has as many columns as b has rows");
    const std::size_t size = a.rows * b.columns;
    const std::size_t pieces = std::max<std::size_t>(1, blocks(a.columns, piece_inner));
    const std::size_t across = blocks(b.columns, block_columns);
    const std::size_t tiles = blocks(a.rows, block_rows) * across;
    // The first piece is summed in c itself.
    std::vector<float> others((pieces - 1) * size);
    parallel_for(tiles * pieces, 1, threads,
                 [&](std::size_t begin, std::size_t end)
                 {
                     for (std::size_t i = begin; i < end; ++i)
                     {
                         const std::size_t piece = i % pieces;
                         const std::size_t tile = i / pieces;
                         Block block(a, b, block_of(tile / across, block_rows, a.rows),
                                     block_of(tile % across, block_columns, b.columns));
                         block.add(block_of(piece, piece_inner, a.columns));
                         block.write(piece == 0 ? c : others.data() + (piece - 1) * size, b.columns);
                     }
                 });
    for (std::size_t piece = 1; piece < pieces; ++piece)
        for (std::size_t i = 0; i < size; ++i)
            c[i] += others[(piece - 1) * size + i];
}

}  // namespace fresco
