#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)
#define FRESCO_LANES 8
#define FRESCO_KERNEL avx512_kernel
#define FRESCO_KERNEL_NAME "AVX-512"
#include "tile_kernel.inl"
#else
#include "tile_kernel.h"

const raster::TileKernel* raster::avx512_kernel()
{
    return nullptr;
}
#endif
