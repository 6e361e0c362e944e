// Why an evaluation failed, for messages: outside the hot path, law by law.
#pragma once

#include <cstdint>
#include <string>

#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// Why forces, and energies or derivatives where these are asked for, at this state are not finite or could not be
// evaluated: the first node, in the user's numbers, whose position or velocity is not finite, or the first spring, then
// element, whose law answered so, or failed, at finite input. Empty if there is none.
enum class Asked : std::uint8_t { forces, forces_and_energies, forces_and_derivatives };
[[nodiscard]] std::string explain_failure(const Layout& layout, InstructionSet set, double time,
                                          const NodeArrays& nodes, Asked asked = Asked::forces);

// One law's answers to explain_failure(), 0 where it was not asked for more than the force.
struct LawAnswer {
  double force = 0.0, energy = 0.0, by_q = 0.0, by_rate = 0.0;

  // Where the law is to put them.
  [[nodiscard]] LawOutputs outputs(const Law& law, Asked asked);
};
// What of an answer is wrong, to be told; empty where all is finite.
[[nodiscard]] std::string wrong_answer(const Component& component, springnet_status status, const LawAnswer& answer,
                                       const springnet_message& message);

}  // namespace springnet::layers
