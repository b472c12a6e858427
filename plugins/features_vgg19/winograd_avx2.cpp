#if defined(__AVX2__) && defined(__FMA__)
#define FRESCO_LANES 8
#define FRESCO_PANEL_VECTORS 2
#define FRESCO_KERNEL avx2_kernel
#define FRESCO_KERNEL_NAME "AVX2"
#include "winograd_kernel.inl"
#else
#include "winograd_kernel.h"

const winograd::Kernel* winograd::avx2_kernel()
{
    return nullptr;
}
#endif
