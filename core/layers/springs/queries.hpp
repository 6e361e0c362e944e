// Queries about chosen springs: tensions, energies, rupture margins, failures. Outside the hot path.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "layers/failure.hpp"
#include "layers/instruction_set.hpp"
#include "layers/law_pair.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// Geometry and laws of `count` <= max_segment springs of one group. directions: relative velocities are wanted also
// where no law reads them.
springnet_status evaluate_springs(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                  std::size_t group, const std::uint32_t* springs, std::size_t count,
                                  SegmentGeometry& geometry, const PairOutputs& out, springnet_message& message,
                                  bool directions = true);

// Axial tension of a live spring, N; laws along the relative velocity do not contribute.
[[nodiscard]] double spring_tension(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                    std::uint32_t spring);
// The same of all springs; 0 for removed ones, nan where a law fails. out: [spring_count]
void spring_tensions(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out);
// Energy stored by the laws of each spring, J; 0 for removed springs and viscosity functions without an energy, nan for
// a spring function that has none, or a law that fails. out: [spring_count]
void spring_energies(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out);
// Energy stored by all laws of live springs that have an energy, J; nan if one fails.
[[nodiscard]] double spring_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes);

// Live springs one of whose laws can rupture, and, in the same order, the smaller margin of their two laws. Returns the
// status of the first law that failed.
[[nodiscard]] std::vector<std::uint32_t> rupturing_springs(const Layout& layout);
springnet_status spring_margins(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                const std::vector<std::uint32_t>& springs, double* margins, springnet_message& message);

// Describes the first spring one of whose laws failed or answered a number that is not finite. Empty if there is none.
[[nodiscard]] std::string explain_spring_failure(const Layout& layout, InstructionSet set, double time,
                                                 const NodeArrays& nodes, Requested requested);

}  // namespace springnet::layers
