// The loops of patch_kernel.h with vectors of FRESCO_VECTOR_BYTES. Compiled several times for other processors, so that it must
// not use anything inline from elsewhere: the linker might take this copy for all.

#include "patch_kernel.h"

namespace fresco::synthesize
{
#if FRESCO_VECTOR_BYTES > 0
namespace
{

constexpr std::size_t lanes = FRESCO_VECTOR_BYTES / 4;
constexpr std::size_t vectors = FRESCO_VECTOR_BYTES == 64 ? 4 : 2;
constexpr std::size_t rows = 6;

typedef float Vector __attribute__((vector_size(lanes * 4), aligned(4), may_alias));
typedef std::int32_t Numbers __attribute__((vector_size(lanes * 4), aligned(4), may_alias));

void compare(const float* queries, const float* panel, std::size_t inner, std::int32_t number, float* least, std::int32_t* where)
{
    Vector sums[rows][vectors] = {};
    for (std::size_t k = 0; k < inner; ++k)
    {
        Vector keys[vectors];
        for (std::size_t v = 0; v < vectors; ++v)
            keys[v] = *reinterpret_cast<const Vector*>(panel + v * lanes);
        panel += vectors * lanes;
        for (std::size_t row = 0; row < rows; ++row)
        {
            const float value = queries[row * inner + k];
            for (std::size_t v = 0; v < vectors; ++v)
                sums[row][v] += keys[v] * value;
        }
    }
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t v = 0; v < vectors; ++v)
        {
            Vector& best = *reinterpret_cast<Vector*>(least + (row * vectors + v) * lanes);
            Numbers& best_number = *reinterpret_cast<Numbers*>(where + (row * vectors + v) * lanes);
            const Numbers is_less = sums[row][v] < best;
            best = is_less ? sums[row][v] : best;
            best_number = is_less ? Numbers{} + number : best_number;
        }
}

float squared_distance(const float* a, const float* b, std::size_t b_stride, std::size_t row_count, std::size_t length)
{
    Vector sums = {};
    float rest = 0;
    for (std::size_t row = 0; row < row_count; ++row, a += length, b += b_stride)
    {
        std::size_t i = 0;
        for (; i + lanes <= length; i += lanes)
        {
            const Vector away = *reinterpret_cast<const Vector*>(a + i) - *reinterpret_cast<const Vector*>(b + i);
            sums += away * away;
        }
        for (; i < length; ++i)
            rest += (a[i] - b[i]) * (a[i] - b[i]);
    }
    for (std::size_t i = 0; i < lanes; ++i)
        rest += sums[i];
    return rest;
}

}  // namespace
#endif

const PatchKernel* FRESCO_KERNEL()
{
#if FRESCO_VECTOR_BYTES > 0
    static constexpr PatchKernel kernel{FRESCO_KERNEL_NAME, rows, vectors * lanes, compare, squared_distance};
    return &kernel;
#else
    return nullptr;
#endif
}

}  // namespace fresco::synthesize
