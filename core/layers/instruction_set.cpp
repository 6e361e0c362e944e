#include "layers/instruction_set.hpp"

#include <springnet/sdk/plugin.h>
#include <springnet/error.hpp>

#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace springnet::layers {

InstructionSet choose_instruction_set(InstructionSet wanted) {
#if defined(__x86_64__) && !defined(SPRINGNET_GENERIC_ONLY)
  const bool has_avx2 = __builtin_cpu_supports("avx2") != 0;
  const bool has_avx512 = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
                          __builtin_cpu_supports("avx512vl") != 0;
#else
  const bool has_avx2 = false;
  const bool has_avx512 = false;
#endif
  switch (wanted) {
    case InstructionSet::best:
      return has_avx512 ? InstructionSet::avx512 : has_avx2 ? InstructionSet::avx2 : InstructionSet::generic;
    case InstructionSet::avx512:
      if (!has_avx512)
        throw Error(ErrorKind::input,
                    "instruction set 'avx512' is not available on this processor or not in this build; use 'best'");
      break;
    case InstructionSet::avx2:
      if (!has_avx2)
        throw Error(ErrorKind::input,
                    "instruction set 'avx2' is not available on this processor or not in this build; use 'best'");
      break;
    case InstructionSet::generic:
      break;
  }
  return wanted;
}

const Kernels& kernels_for(InstructionSet set) {
#if defined(__x86_64__) && !defined(SPRINGNET_GENERIC_ONLY)
  if (set == InstructionSet::avx512) return avx512::kernels();
  if (set == InstructionSet::avx2) return avx2::kernels();
#endif
  static_cast<void>(set);
  return generic::kernels();
}

std::uint32_t abi_number(InstructionSet set) noexcept {
  return set == InstructionSet::avx512 ? SPRINGNET_AVX512
         : set == InstructionSet::avx2 ? SPRINGNET_AVX2
                                       : SPRINGNET_GENERIC;
}

#if defined(__x86_64__)
FlushDenormals::FlushDenormals() noexcept : saved_(_mm_getcsr()) {
  constexpr unsigned flush_to_zero = 0x8000, denormals_are_zero = 0x0040;
  _mm_setcsr(saved_ | flush_to_zero | denormals_are_zero);
}
FlushDenormals::~FlushDenormals() { _mm_setcsr(saved_); }
#else
FlushDenormals::FlushDenormals() noexcept = default;
FlushDenormals::~FlushDenormals() = default;
#endif

}  // namespace springnet::layers
