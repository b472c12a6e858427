#if defined(__AVX2__) && defined(__FMA__)
#define FRESCO_LANES 8
#define FRESCO_PANEL_VECTORS 2
#define FRESCO_KERNEL avx2_kernel
#define FRESCO_KERNEL_NAME "AVX2"
#include "matrix_kernel.inl"
#else
#include "matrix_kernel.h"

const fresco::matrix::Kernel* fresco::matrix::avx2_kernel()
{
    return nullptr;
}
#endif
