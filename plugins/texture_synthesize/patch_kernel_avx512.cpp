#if defined(__AVX512F__) && defined(__AVX512BW__) && defined(__AVX512VL__) && defined(__AVX512DQ__)
#define FRESCO_LANES 16
#define FRESCO_PANEL_VECTORS 4
#define FRESCO_KERNEL avx512_patch_kernel
#define FRESCO_KERNEL_NAME "AVX-512"
#include "patch_kernel.inl"
#else
#include "patch_kernel.h"

const fresco::synthesize::PatchKernel* fresco::synthesize::avx512_patch_kernel()
{
    return nullptr;
}
#endif
