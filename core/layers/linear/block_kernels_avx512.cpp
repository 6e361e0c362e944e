#define KERNEL_NAMESPACE avx512
#include "layers/linear/block_kernels.inl"
