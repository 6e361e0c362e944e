// Whether this processor and this build have the instruction set named; status 77 tells ctest that they do not.
// Tests of kernels compare all sets that there are; this reports which were not among them.
#include <cstdio>
#include <string_view>

#include <springnet/error.hpp>

#include "layers/instruction_set.hpp"

int main(int count, char** arguments) {
  using springnet::InstructionSet;
  const std::string_view name = count == 2 ? arguments[1] : "";
  if (name != "avx2" && name != "avx512") {
    std::fputs("usage: has_instruction_set avx2|avx512\n", stderr);
    return 2;
  }
  try {
    static_cast<void>(
        springnet::layers::choose_instruction_set(name == "avx2" ? InstructionSet::avx2 : InstructionSet::avx512));
  } catch (const springnet::Error& error) {
    std::printf("skipped: %s\n", error.what());
    return 77;
  }
  return 0;
}
