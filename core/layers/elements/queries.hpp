// Queries about chosen elements: values, forces, energies, margins. Outside the hot path.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "layers/failure.hpp"
#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// The invariant as its law reads it, and its rate; of a removed element too.
struct ElementState {
  double value;
  double rate;
};
[[nodiscard]] ElementState element_state(const Layout& layout, const NodeArrays& nodes, std::uint32_t element);
// Q of a live element, both laws together; nan where a law fails.
[[nodiscard]] double element_force(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                   std::uint32_t element);
// Energy stored in all live elements whose spring function has one, J.
[[nodiscard]] double element_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes);

// Live elements whose law can rupture, by number, and the smaller margin of their two laws in that order.
[[nodiscard]] std::vector<std::uint32_t> rupturing_elements(const Layout& layout);
springnet_status element_margins(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                 const std::vector<std::uint32_t>& elements, double* margins,
                                 springnet_message& message);

// The first element, in the user's numbers, whose law answered a number that is not finite, or failed. Empty if there
// is none.
[[nodiscard]] std::string explain_element_failure(const Layout& layout, InstructionSet set, double time,
                                                  const NodeArrays& nodes, Asked asked);

}  // namespace springnet::layers
