#define FRESCO_LANES 2
#define FRESCO_KERNEL base_kernel
#define FRESCO_KERNEL_NAME "any processor"
#include "tile_kernel.inl"
