#pragma once

namespace springnet {

enum class InstructionSet { best, generic, avx2, avx512 };  // all give the same bits

}  // namespace springnet
