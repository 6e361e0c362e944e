// Queries about chosen elements: values, forces, energies, rupture margins, failures. Outside the hot path.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "layers/elements/several.hpp"
#include "layers/failure.hpp"
#include "layers/instruction_set.hpp"
#include "layers/law_pair.hpp"
#include "layers/layout.hpp"

namespace springnet::layers {

// The invariant as laws read it, and its rate; also of a removed element.
struct ElementState {
  double value;
  double rate;
};
[[nodiscard]] ElementState element_state(const Layout& layout, const NodeArrays& nodes, std::uint32_t element);
// The laws of one element, whose state is given.
springnet_status evaluate_element(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                  std::uint32_t element, const ElementState& state, const PairOutputs& out,
                                  springnet_message& message);
// The laws of one element that read several scalars; `geometry` and `out` have it as member 0.
struct SeveralQuery {
  SeveralGeometry geometry;
  SeveralAnswers answers;
};
springnet_status evaluate_several_element(const Layout& layout, InstructionSet set, double time,
                                          const NodeArrays& nodes, std::uint32_t element, SeveralWanted wanted,
                                          SeveralQuery& out, springnet_message& message);
// Q of a live element, summed over both laws; nan where one fails, and for laws over several scalars.
[[nodiscard]] double element_force(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                   std::uint32_t element);
// Energy stored by all laws of live elements that have an energy, J; nan if one fails.
[[nodiscard]] double element_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes);

// Live elements one of whose laws can rupture, and, in the same order, the smaller margin of their two laws. Returns
// the status of the first law that failed.
[[nodiscard]] std::vector<std::uint32_t> rupturing_elements(const Layout& layout);
springnet_status element_margins(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                 const std::vector<std::uint32_t>& elements, double* margins,
                                 springnet_message& message);

// Describes the first element one of whose laws failed or answered a number that is not finite. Empty if there is none.
[[nodiscard]] std::string explain_element_failure(const Layout& layout, InstructionSet set, double time,
                                                  const NodeArrays& nodes, Requested requested);

}  // namespace springnet::layers
