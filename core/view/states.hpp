// Internal states of laws as colours of springs.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <springnet/scene.hpp>

#include "view/selection.hpp"

namespace springnet::view {

struct States {
  struct Of {
    std::string label;  // "flow of maxwell"
    std::string unit;   // empty: dimensionless
  };
  std::vector<Of> all;
  // Of a spring of each material, as numbers in `all` and in the order of Simulation::internal_states().
  std::vector<std::vector<std::uint32_t>> of_material;
  std::size_t numbers = 0;  // in a frame, of all springs shown
};

// law_states: of the laws of the network that have any. Without a selection: of no spring.
[[nodiscard]] States states_of(const Network& network, const std::vector<LawStates>& law_states);
void count_states(const Network& network, const Selection& selection, States& states);
// Of a spring, over all springs.
[[nodiscard]] double mean_states(const Network& network, const States& states);

// out: [states.numbers] spring by spring.
void take_states(const States& states, const Network& network, const Selection& selection, const Simulation& simulation,
                 std::span<float> out);

}  // namespace springnet::view
