#if defined(__AVX512F__)
#define FRESCO_LANES 16
#define FRESCO_PANEL_VECTORS 4
#define FRESCO_KERNEL avx512_kernel
#define FRESCO_KERNEL_NAME "AVX-512"
#include "winograd_kernel.inl"
#else
#include "winograd_kernel.h"

const winograd::Kernel* winograd::avx512_kernel()
{
    return nullptr;
}
#endif
