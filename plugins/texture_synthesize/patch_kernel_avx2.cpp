#if defined(__AVX2__) && defined(__FMA__)
#define FRESCO_LANES 8
#define FRESCO_PANEL_VECTORS 2
#define FRESCO_KERNEL avx2_patch_kernel
#define FRESCO_KERNEL_NAME "AVX2"
#include "patch_kernel.inl"
#else
#include "patch_kernel.h"

const fresco::synthesize::PatchKernel* fresco::synthesize::avx2_patch_kernel()
{
    return nullptr;
}
#endif
