#define FRESCO_LANES 4
#define FRESCO_PANEL_VECTORS 2
#define FRESCO_KERNEL base_kernel
#define FRESCO_KERNEL_NAME "any processor"
#include "matrix_kernel.inl"
