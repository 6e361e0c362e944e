#define KERNEL_NAMESPACE avx2
#include "layers/kernels.inl"
