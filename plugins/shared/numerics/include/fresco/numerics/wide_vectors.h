#pragma once

#include <cstddef>
#include <cstdint>

/// \file Vectors of eight numbers for inner loops, and FRESCO_WIDE_VECTORS for the functions that have them: these are compiled
/// twice, for processors with AVX2 and for all others, together with what they call. Both do the same operations in the same
/// order. Pass vectors to functions by reference: how they are passed by value depends on the processor.

// A sanitizer cannot watch the choice between the two, which is made before it starts.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__) &&                          \
    !defined(__SANITIZE_ADDRESS__)
#define FRESCO_WIDE_VECTORS __attribute__((target_clones("avx2", "default"), flatten))
#else
#define FRESCO_WIDE_VECTORS
#endif

namespace fresco::numerics::wide_vectors
{

typedef float Floats __attribute__((vector_size(32)));
typedef std::int32_t Ints __attribute__((vector_size(32)));
inline constexpr std::size_t lanes = sizeof(Floats) / sizeof(float);

}  // namespace fresco::numerics::wide_vectors
