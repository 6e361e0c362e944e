#define KERNEL_NAMESPACE avx2
#include "layers/linear/spring_kernels.inl"
