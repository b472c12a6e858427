// The loop of matrix_kernel.h with vectors of FRESCO_VECTOR_BYTES. Compiled several times for other processors, so that it must
// not use anything inline from elsewhere: the linker might take this copy for all.

#include "matrix_kernel.h"

namespace fresco::matrix
{
#if FRESCO_VECTOR_BYTES > 0
namespace
{

constexpr std::size_t lanes = FRESCO_VECTOR_BYTES / 4;
constexpr std::size_t vectors = FRESCO_VECTOR_BYTES == 64 ? 4 : 2;
constexpr std::size_t rows = 6;

typedef float Vector __attribute__((vector_size(lanes * 4), aligned(4), may_alias));

void multiply(const float* const* a, std::ptrdiff_t a_step, const float* b, std::ptrdiff_t b_step, std::size_t inner, float* c,
              std::size_t stride)
{
    const float* a_rows[rows];
    for (std::size_t row = 0; row < rows; ++row)
        a_rows[row] = a[row];
    Vector sums[rows][vectors] = {};
    for (std::size_t k = 0; k < inner; ++k)
    {
        Vector panel[vectors];
        for (std::size_t v = 0; v < vectors; ++v)
            panel[v] = *reinterpret_cast<const Vector*>(b + v * lanes);
        b += b_step;
        for (std::size_t row = 0; row < rows; ++row)
        {
            const float value = *a_rows[row];
            a_rows[row] += a_step;
            for (std::size_t v = 0; v < vectors; ++v)
                sums[row][v] += panel[v] * value;
        }
    }
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t v = 0; v < vectors; ++v)
            *reinterpret_cast<Vector*>(c + row * stride + v * lanes) += sums[row][v];
}

}  // namespace
#endif

const Kernel* FRESCO_KERNEL()
{
#if FRESCO_VECTOR_BYTES > 0
    static constexpr Kernel kernel{FRESCO_KERNEL_NAME, rows, vectors * lanes, multiply};
    return &kernel;
#else
    return nullptr;
#endif
}

}  // namespace fresco::matrix
