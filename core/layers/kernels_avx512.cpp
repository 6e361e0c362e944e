#define KERNEL_NAMESPACE avx512
#include "layers/kernels.inl"
