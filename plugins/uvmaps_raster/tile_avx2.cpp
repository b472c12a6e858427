#if defined(__AVX2__) && defined(__FMA__)
#define FRESCO_LANES 4
#define FRESCO_KERNEL avx2_kernel
#define FRESCO_KERNEL_NAME "AVX2"
#include "tile_kernel.inl"
#else
#include "tile_kernel.h"

const raster::TileKernel* raster::avx2_kernel()
{
    return nullptr;
}
#endif
