// Queries about chosen springs: lengths, tensions, energies, derivatives, margins. Outside the hot path.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "layers/failure.hpp"
#include "layers/instruction_set.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// Geometry and laws of `count` <= max_segment springs of one group. Output arrays are [count]; null where not wanted.
springnet_status evaluate_springs(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                  std::size_t group, const std::uint32_t* springs, std::size_t count,
                                  SegmentGeometry& geometry, const LawOutputs& spring, const LawOutputs& viscosity,
                                  springnet_message& message);

// Axial tension of a live spring, N. Laws along the relative velocity do not count.
[[nodiscard]] double spring_tension(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                    std::uint32_t spring);
// The same of all springs, by number; 0 for those that were removed. out: [spring_count]
void spring_tensions(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out);
// What each spring's function has stored, J: 0 for removed springs and viscous connections, nan for a law without an
// energy. out: [spring_count]
void spring_energies(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out);
// Energy stored in all live springs whose spring function has one, J.
[[nodiscard]] double spring_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes);

// Live springs whose law can rupture, by number, and the smaller margin of their two laws in that order.
[[nodiscard]] std::vector<std::uint32_t> rupturing_springs(const Layout& layout);
springnet_status spring_margins(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                const std::vector<std::uint32_t>& springs, double* margins, springnet_message& message);

// The first spring, by number, whose law failed or answered a number that is not finite, told with its ends in the
// user's numbers. Empty if there is none.
[[nodiscard]] std::string explain_spring_failure(const Layout& layout, InstructionSet set, double time,
                                                 const NodeArrays& nodes, Asked asked);

}  // namespace springnet::layers
