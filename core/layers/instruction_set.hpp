// Choice of the instruction set.
#pragma once

#include <cstdint>

#include <springnet/instruction_set.hpp>

#include "layers/kernels.hpp"

namespace springnet::layers {

// `wanted`, or the best that this processor has for InstructionSet::best. Throws Error(input) if the processor does not
// have it.
[[nodiscard]] InstructionSet choose_instruction_set(InstructionSet wanted);
[[nodiscard]] const Kernels& kernels_for(InstructionSet set);
[[nodiscard]] std::uint32_t abi_number(InstructionSet set) noexcept;  // SPRINGNET_GENERIC …

// While it lives, denormal numbers are flushed to zero on this thread: a network coming to rest would otherwise run
// several times slower. Restores the host's setting.
class FlushDenormals {
 public:
  FlushDenormals() noexcept;
  ~FlushDenormals();
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned saved_ = 0;
};

}  // namespace springnet::layers
