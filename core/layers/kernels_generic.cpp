#define KERNEL_NAMESPACE generic
#include "layers/kernels.inl"
