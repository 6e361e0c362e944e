#include "view/states.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "view/rounding.hpp"

namespace springnet::view {

States states_of(const Network& network, const std::vector<LawStates>& law_states) {
  States states;
  states.of_material.resize(network.materials().size());
  std::vector<bool> used(network.materials().size(), false);
  for (SpringIndex k = 0; !law_states.empty() && k < network.springs().size(); ++k)
    used[network.springs().materials()[k]] = true;
  for (const LawStates& law : law_states) {
    const bool viscosity = law.kind == ComponentKind::viscosity_function;
    const auto first = static_cast<std::uint32_t>(states.all.size());
    bool any = false;
    for (std::size_t m = 0; m < used.size(); ++m) {
      const Material& material = network.materials()[m];
      const std::optional<LawUse>& use = viscosity ? material.viscosity : material.spring;
      if (!used[m] || !use || use->id != law.law) continue;
      any = true;
      std::vector<std::uint32_t>& own = states.of_material[m];
      std::vector<std::uint32_t> numbers(law.states.size());
      for (std::uint32_t j = 0; j < numbers.size(); ++j) numbers[j] = first + j;
      own.insert(viscosity ? own.end() : own.begin(), numbers.begin(), numbers.end());
    }
    if (!any) continue;
    for (const InternalState& state : law.states) {
      std::string name = state.name;
      std::replace(name.begin(), name.end(), '_', ' ');
      states.all.push_back({fmt::format("{} of {}{}", name, viscosity ? "viscosity " : "", law.law),
                            state.unit == "1" ? "" : state.unit});
    }
  }
  return states;
}

void count_states(const Network& network, const Selection& selection, States& states) {
  states.numbers = 0;
  if (states.all.empty()) return;
  for (const SpringIndex k : selection.springs)
    states.numbers += states.of_material[network.springs().materials()[k]].size();
}

double mean_states(const Network& network, const States& states) {
  if (states.all.empty()) return 0.0;
  double sum = 0.0;
  for (SpringIndex k = 0; k < network.springs().size(); ++k)
    sum += static_cast<double>(states.of_material[network.springs().materials()[k]].size());
  return sum / static_cast<double>(network.springs().size());
}

void take_states(const States& states, const Network& network, const Selection& selection, const Simulation& simulation,
                 std::span<float> out) {
  if (states.numbers == 0) return;
  auto at = out.begin();
  for (const SpringIndex k : selection.springs) {
    if (states.of_material[network.springs().materials()[k]].empty()) continue;
    for (const double value : simulation.internal_states(k)) *at++ = to_float(value);
  }
}

}  // namespace springnet::view
