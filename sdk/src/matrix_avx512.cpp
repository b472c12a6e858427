#if defined(__AVX512F__)
#define FRESCO_LANES 16
#define FRESCO_PANEL_VECTORS 4
#define FRESCO_KERNEL avx512_kernel
#define FRESCO_KERNEL_NAME "AVX-512"
#include "matrix_kernel.inl"
#else
#include "matrix_kernel.h"

const fresco::matrix::Kernel* fresco::matrix::avx512_kernel()
{
    return nullptr;
}
#endif
