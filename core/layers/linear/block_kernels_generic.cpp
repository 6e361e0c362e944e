#define KERNEL_NAMESPACE generic
#include "layers/linear/block_kernels.inl"
