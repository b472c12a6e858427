#if defined(__AVX2__) && defined(__FMA__)
#define FRESCO_KERNEL avx2_kernel
#define FRESCO_KERNEL_NAME "AVX2"
#include "shading_kernel.inl"
#else
#include "shading_kernel.h"

const fresco::shading::Kernel* fresco::shading::avx2_kernel()
{
    return nullptr;
}
#endif
