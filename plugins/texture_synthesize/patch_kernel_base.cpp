#define FRESCO_LANES 4
#define FRESCO_PANEL_VECTORS 2
#define FRESCO_KERNEL base_patch_kernel
#define FRESCO_KERNEL_NAME "any"
#include "patch_kernel.inl"
