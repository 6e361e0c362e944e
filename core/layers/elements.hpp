// Questions about chosen springs: lengths, tensions, energies, derivatives, margins. Outside the hot path.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// Geometry and laws of `count` <= max_segment springs of one group. Output arrays are [count]; null where not wanted.
springnet_status evaluate_elements(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                   std::size_t group, const std::uint32_t* springs, std::size_t count,
                                   SegmentGeometry& geometry, const LawOutputs& spring, const LawOutputs& viscosity,
                                   springnet_message& message);

// Axial tension of a live spring, N. Laws along the relative velocity do not count.
[[nodiscard]] double tension(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                             std::uint32_t spring);
// The same of all springs, by number; 0 for those that were removed. out: [spring_count]
void all_tensions(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out);
// What each spring's function has stored, J: 0 for removed springs and viscous connections, nan for a law without an
// energy. out: [spring_count]
void all_energies(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out);
// Energy stored in all live springs whose spring function has one, J.
[[nodiscard]] double elastic_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes);

// Live springs whose law can rupture, by number, and the smaller margin of their two laws in that order.
[[nodiscard]] std::vector<std::uint32_t> rupturing_springs(const Layout& layout);
springnet_status rupture_margins(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                 const std::vector<std::uint32_t>& springs, double* margins,
                                 springnet_message& message);

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
