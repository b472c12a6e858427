// The loops of patch_kernel.h with vectors of FRESCO_VECTOR_BYTES. Compiled several times for other processors, so that it must
// not use anything inline from elsewhere: the linker might take this copy for all.

#include "patch_kernel.h"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O3")  // Else only loops without a rest become vectors.
#endif

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

float squared_distance(const std::int16_t* a, const std::int16_t* b, std::size_t b_stride, std::size_t row_count,
                       std::size_t length)
{
    std::int64_t total = 0;
    for (std::size_t row = 0; row < row_count; ++row, a += length, b += b_stride)
    {
        std::int32_t sum = 0;  // The compiler makes vectors of it: products of 16 bits, added up in pairs.
        for (std::size_t i = 0; i < length; ++i)
        {
            const auto away = static_cast<std::int16_t>(a[i] - b[i]);
            sum += away * away;
        }
        total += sum;
    }
    return static_cast<float>(total);
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
