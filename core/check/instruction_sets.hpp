// The instruction sets of this processor that components are called with.
#pragma once

#include <cstdint>
#include <vector>

namespace springnet::check {

struct InstructionSetName {
  std::uint32_t number;  // SPRINGNET_GENERIC ...
  const char* name;
};
// From the least to the best.
[[nodiscard]] std::vector<InstructionSetName> instruction_sets();

}  // namespace springnet::check
