#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)
#define FRESCO_KERNEL avx512_kernel
#define FRESCO_KERNEL_NAME "AVX-512"
#include "shading_kernel.inl"
#else
#include "shading_kernel.h"

const fresco::shading::Kernel* fresco::shading::avx512_kernel()
{
    return nullptr;
}
#endif
