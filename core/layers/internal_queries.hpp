// Internal states at the start of a run, and what steps of them read of their start.
#pragma once

#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// The states of all springs and elements as their laws begin; `out` [internal_count].
springnet_status start_states(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                              double* out, springnet_message& message);

// Invariants and rates of springs and elements with internal state, InternalView::start_q and start_rate:
// [internal_count] each, in the place of each law's first state.
void invariants_of_states(const Layout& layout, InstructionSet set, const NodeArrays& nodes, double* q, double* rate);

}  // namespace springnet::layers
