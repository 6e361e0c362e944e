#include "check/instruction_sets.hpp"

#include <springnet/sdk/plugin.h>

namespace springnet::check {

std::vector<InstructionSetName> instruction_sets() {
  std::vector<InstructionSetName> sets{{SPRINGNET_GENERIC, "generic"}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) sets.push_back({SPRINGNET_AVX2, "avx2"});
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd"))
    sets.push_back({SPRINGNET_AVX512, "avx512"});
#endif
  return sets;
}

}  // namespace springnet::check
