#define KERNEL_NAMESPACE avx2
#include "layers/linear/block_kernels.inl"
