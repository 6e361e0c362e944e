// Springs that break at a state.
#pragma once

#include <cstdint>
#include <vector>

#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// Live springs with no margin left, sorted by number, unit by unit on several threads. SPRINGNET_RECOVERABLE, with
// `broken` of no use, if a margin is not a number; the status of a law that failed. Does not throw, but for memory.
springnet_status broken_springs(const Layout& layout, InstructionSet set, unsigned threads, double time,
                                const NodeArrays& nodes, std::vector<std::uint32_t>& broken,
                                springnet_message& message);
// Whether any law of a spring of the net can rupture.
[[nodiscard]] bool can_rupture(const Layout& layout) noexcept;

}  // namespace springnet::layers
