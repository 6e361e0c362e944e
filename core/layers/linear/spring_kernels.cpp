#include "layers/linear/spring_kernels.hpp"

namespace springnet::layers {

const SpringKernels& spring_kernels_for(InstructionSet set) {
#if defined(__x86_64__) && !defined(SPRINGNET_GENERIC_ONLY)
  if (set == InstructionSet::avx512) return avx512::spring_kernels();
  if (set == InstructionSet::avx2) return avx2::spring_kernels();
#endif
  static_cast<void>(set);
  return generic::spring_kernels();
}

}  // namespace springnet::layers
