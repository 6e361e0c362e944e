#define KERNEL_NAMESPACE generic
#include "layers/linear/spring_kernels.inl"
