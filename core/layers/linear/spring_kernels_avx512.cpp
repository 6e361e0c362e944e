#define KERNEL_NAMESPACE avx512
#include "layers/linear/spring_kernels.inl"
