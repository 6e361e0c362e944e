// Why an evaluation failed, for messages: outside the hot path, law by law.
#pragma once

#include <cstdint>
#include <string>

#include "layers/instruction_set.hpp"
#include "layers/law_pair.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// Why forces, or the energies or derivatives asked for, are not finite or cannot be evaluated at a state: the first
// node (user's number) whose position or velocity is not finite, else the first spring, else the first element, one of
// whose laws failed or answered a number that is not finite. Empty if there is none.
enum class Requested : std::uint8_t { forces, forces_and_energies, forces_and_derivatives };
[[nodiscard]] std::string explain_failure(const Layout& layout, InstructionSet set, double time,
                                          const NodeArrays& nodes, Requested requested = Requested::forces);

// One law's answers for one spring or element; 0 where not asked for.
struct LawAnswer {
  double force = 0.0, energy = 0.0, by_q = 0.0, by_rate = 0.0;

  // Pointers to them, as far as the law offers what is asked.
  [[nodiscard]] LawOutputs outputs(const Law& law, Requested requested);
};
// Describes what is wrong with an answer; empty if the law succeeded and all is finite.
[[nodiscard]] std::string wrong_answer(const Component& component, springnet_status status, const LawAnswer& answer,
                                       const springnet_message& message);

}  // namespace springnet::layers
