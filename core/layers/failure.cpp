#include "layers/failure.hpp"

#include <fmt/format.h>

#include <cmath>

#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"
#include "plugin_host/call.hpp"

namespace springnet::layers {

LawOutputs LawAnswer::outputs(const Law& law, Requested requested) {
  LawOutputs out;
  out.force = &force;
  if (requested == Requested::forces_and_energies && law.can(SPRINGNET_HAS_ENERGY)) out.energy = &energy;
  if (requested == Requested::forces_and_derivatives && law.can(SPRINGNET_HAS_DERIVATIVES)) {
    out.by_q = &by_q;
    out.by_rate = &by_rate;
  }
  return out;
}

std::string wrong_answer(const Component& component, springnet_status status, const LawAnswer& answer,
                         const springnet_message& message) {
  // fmt writes the sign of a nan, which depends on the processor.
  const auto number = [](double value) { return std::isnan(value) ? std::string("nan") : fmt::format("{}", value); };
  if (status != SPRINGNET_OK) return text_of(message) + ";";
  const std::string name = full_name(component);
  if (!std::isfinite(answer.force)) return fmt::format("{} answered {}", name, number(answer.force));
  if (!std::isfinite(answer.energy)) return fmt::format("{} answered an energy of {}", name, number(answer.energy));
  if (!std::isfinite(answer.by_q)) return fmt::format("{} answered a derivative of {}", name, number(answer.by_q));
  if (!std::isfinite(answer.by_rate))
    return fmt::format("{} answered a derivative with respect to the rate of {}", name, number(answer.by_rate));
  return {};
}

std::string explain_failure(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                            Requested requested) {
  const std::vector<std::uint32_t>& engine = layout.ordering().engine;
  for (std::size_t user = 0; user < engine.size(); ++user) {
    const std::uint32_t k = engine[user];
    const bool position = std::isfinite(nodes.px[k]) && std::isfinite(nodes.py[k]) && std::isfinite(nodes.pz[k]);
    const bool velocity = std::isfinite(nodes.vx[k]) && std::isfinite(nodes.vy[k]) && std::isfinite(nodes.vz[k]);
    if (!position || !velocity)
      return fmt::format("the {} of node {} is not a finite number", position ? "velocity" : "position", user);
  }
  const std::string spring = explain_spring_failure(layout, set, time, nodes, requested);
  return spring.empty() ? explain_element_failure(layout, set, time, nodes, requested) : spring;
}

}  // namespace springnet::layers
