#include "layers/linear/block_kernels.hpp"

namespace springnet::layers {

const BlockKernels& block_kernels_for(InstructionSet set) {
#if defined(__x86_64__) && !defined(SPRINGNET_GENERIC_ONLY)
  if (set == InstructionSet::avx512) return avx512::block_kernels();
  if (set == InstructionSet::avx2) return avx2::block_kernels();
#endif
  static_cast<void>(set);
  return generic::block_kernels();
}

}  // namespace springnet::layers
