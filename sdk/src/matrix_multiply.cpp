#include <fresco/math.h>
#include <fresco/parallel.h>

#include "matrix_kernel.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace fresco
{
namespace
{

// A panel of b (block_inner rows) stays in the first-level caches while the rows of a pass by it.
constexpr std::size_t block_inner = 256;
constexpr std::size_t block_rows = 96;
constexpr std::size_t block_columns = 256;
// Terms of one piece of a long sum: enough work for a thread, few enough to lose no digit that matters.
constexpr std::size_t piece_inner = 8192;

struct Span
{
    std::size_t begin = 0;
    std::size_t end = 0;

    std::size_t size() const { return end - begin; }
};

Span block_of(std::size_t number, std::size_t size, std::size_t count)
{
    return {number * size, std::min(count, (number + 1) * size)};
}

std::size_t blocks(std::size_t count, std::size_t size)
{
    return (count + size - 1) / size;
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
    Block(const MatrixView& a, const MatrixView& b, Span rows, Span columns) : a_(a), b_(b), rows_(rows), columns_(columns)
    {
        stride_ = blocks(columns.size(), kernel_.columns) * kernel_.columns;
        sums_.assign(blocks(rows.size(), kernel_.rows) * kernel_.rows * stride_, 0.0F);
        starts_.resize(kernel_.rows);
    }

    void add(Span inner)
    {
        for (std::size_t k = inner.begin; k < inner.end; k += block_inner)
            for (std::size_t column = columns_.begin; column < columns_.end; column += kernel_.columns)
                add_panel({k, std::min(inner.end, k + block_inner)}, column);
    }

    void write(float* c, std::size_t stride) const
    {
        for (std::size_t row = 0; row < rows_.size(); ++row)
            std::copy_n(sums_.data() + row * stride_, columns_.size(), c + (rows_.begin + row) * stride + columns_.begin);
    }

  private:
    void add_panel(Span inner, std::size_t column)
    {
        const auto [panel, step] = panel_of(inner, column);
        for (std::size_t row = rows_.begin; row < rows_.end; row += kernel_.rows)
        {
            // Rows beyond the last are the last again, and their sums are not used.
            for (std::size_t i = 0; i < kernel_.rows; ++i)
                starts_[i] = element(a_, std::min(row + i, rows_.end - 1), inner.begin);
            kernel_.multiply(starts_.data(), a_.column_stride, panel, step, inner.size(),
                             sums_.data() + (row - rows_.begin) * stride_ + (column - columns_.begin), stride_);
        }
    }

    struct Panel
    {
        const float* values;
        std::ptrdiff_t step;
    };

    /// b itself where its columns lie side by side, else a copy where they do; missing columns are zero.
    Panel panel_of(Span inner, std::size_t column)
    {
        const std::size_t there = std::min(kernel_.columns, columns_.end - column);
        const float* from = element(b_, inner.begin, column);
        if (b_.column_stride == 1 && there == kernel_.columns)
            return {from, b_.row_stride};
        copy_.assign(inner.size() * kernel_.columns, 0.0F);
        for (std::size_t i = 0; i < there; ++i)
            for (std::size_t k = 0; k < inner.size(); ++k)
                copy_[k * kernel_.columns + i] =
                    from[static_cast<std::ptrdiff_t>(i) * b_.column_stride + static_cast<std::ptrdiff_t>(k) * b_.row_stride];
        return {copy_.data(), static_cast<std::ptrdiff_t>(kernel_.columns)};
    }

    const matrix::Kernel& kernel_ = matrix::fastest_kernel();
    const MatrixView& a_;
    const MatrixView& b_;
    Span rows_;
    Span columns_;
    std::size_t stride_ = 0;
    std::vector<float> sums_;
    std::vector<float> copy_;
    std::vector<const float*> starts_;
};

}  // namespace

const matrix::Kernel& matrix::fastest_kernel()
{
    static const auto& fastest = fastest_of(avx512_kernel(), avx2_kernel(), base_kernel());
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
