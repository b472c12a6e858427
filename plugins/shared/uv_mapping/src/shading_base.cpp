#define FRESCO_KERNEL base_kernel
#define FRESCO_KERNEL_NAME "any processor"
#include "shading_kernel.inl"
