#include "layers/elements/queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "plugin_host/call.hpp"

namespace springnet::layers {
namespace {

// One law of one element.
springnet_status ask(const Layout& layout, InstructionSet set, double time, std::uint32_t element, const Law& law,
                     const ElementState& state, const LawOutputs& out, springnet_message& message) {
  const ElementLayout& elements = layout.elements();
  const Group& group = layout.laws().groups[elements.group(element)];
  return call_law(group, law, abi_number(set), time, 1, {nullptr, elements.row(element)}, &state.value, &state.rate,
                  out, &message);
}

const Group& group_of(const Layout& layout, std::uint32_t element) {
  return layout.laws().groups[layout.elements().group(element)];
}

// "nodes 1, 2 and 3"; an enclosure has too many.
std::string where(const Layout& layout, std::uint32_t element) {
  const ElementLayout& elements = layout.elements();
  const std::span<const std::uint32_t> nodes = elements.nodes(element);
  if (elements.invariant(element) == Invariant::enclosed_volume) return fmt::format("{} nodes", nodes.size());
  std::string text = "nodes ";
  for (std::size_t i = 0; i < nodes.size(); ++i)
    text += fmt::format("{}{}", i == 0 ? "" : i + 1 < nodes.size() ? ", " : " and ", layout.ordering().user[nodes[i]]);
  return text;
}

}  // namespace

ElementState element_state(const Layout& layout, const NodeArrays& nodes, std::uint32_t element) {
  const ElementLayout& elements = layout.elements();
  if (elements.invariant(element) == Invariant::enclosed_volume) {
    for (const ElementLayout::EnclosureElement& enclosure : elements.enclosures()) {
      if (enclosure.element != element) continue;
      const Enclosure::Values values = enclosure.shape.values(nodes);
      return {values.volume, values.rate};
    }
  }
  const std::span<const std::uint32_t> own = elements.nodes(element);
  Corners corners;
  FirstOrder geometry;
  gather(own.data(), own.size(), nodes, corners);
  first_order(elements.invariant(element), corners, geometry);
  const Invariant invariant = elements.invariant(element);
  return {nearest_turn(invariant, geometry.value, elements.reference(element)), geometry.rate};
}

double element_force(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                     std::uint32_t element) {
  const ElementState state = element_state(layout, nodes, element);
  const Group& group = group_of(layout, element);
  double sum = 0.0;
  for (const Law* law : {&group.spring, &group.viscosity}) {
    if (!*law) continue;
    double value = 0.0;
    LawOutputs out;
    out.force = &value;
    springnet_message message{};
    const bool answered = ask(layout, set, time, element, *law, state, out, message) == SPRINGNET_OK;
    sum += answered ? value : std::numeric_limits<double>::quiet_NaN();
  }
  return sum;
}

double element_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes) {
  double sum = 0.0;
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e) {
    const Law& law = group_of(layout, e).spring;
    if (!layout.elements().alive(e) || !law.can(SPRINGNET_HAS_ENERGY)) continue;
    double force = 0.0, energy = 0.0;
    LawOutputs out;
    out.force = &force;
    out.energy = &energy;
    springnet_message message{};
    if (ask(layout, set, time, e, law, element_state(layout, nodes, e), out, message) != SPRINGNET_OK)
      return std::numeric_limits<double>::quiet_NaN();
    sum += energy;
  }
  return sum;
}

std::vector<std::uint32_t> rupturing_elements(const Layout& layout) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e) {
    const Group& group = group_of(layout, e);
    if (layout.elements().alive(e) &&
        (group.spring.can(SPRINGNET_HAS_RUPTURE) || group.viscosity.can(SPRINGNET_HAS_RUPTURE)))
      found.push_back(e);
  }
  return found;
}

springnet_status element_margins(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                 const std::vector<std::uint32_t>& elements, double* margins,
                                 springnet_message& message) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const std::uint32_t e = elements[i];
    const ElementState state = element_state(layout, nodes, e);
    const Group& group = group_of(layout, e);
    margins[i] = std::numeric_limits<double>::infinity();
    for (const Law* law : {&group.spring, &group.viscosity}) {
      if (!law->can(SPRINGNET_HAS_RUPTURE)) continue;
      double force = 0.0, margin = 0.0;
      LawOutputs out;
      out.force = &force;
      out.margin = &margin;
      const springnet_status status = ask(layout, set, time, e, *law, state, out, message);
      if (status != SPRINGNET_OK) return status;
      margins[i] = lesser(margins[i], margin);
    }
  }
  return SPRINGNET_OK;
}

std::string explain_element_failure(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                    Asked asked) {
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e) {
    if (!layout.elements().alive(e)) continue;
    const Group& group = group_of(layout, e);
    const ElementState state = element_state(layout, nodes, e);
    for (const Law* law : {&group.spring, &group.viscosity}) {
      if (!*law) continue;
      LawAnswer answer;
      const LawOutputs out = answer.outputs(*law, asked);
      springnet_message message{};
      const springnet_status status = ask(layout, set, time, e, *law, state, out, message);
      const std::string what = wrong_answer(*law->component, status, answer, message);
      if (what.empty()) continue;
      const std::string_view unit = unit_of(layout.elements().invariant(e));
      return fmt::format("{} for element {} ({}; {} {} {}, rate {} {}/s)", what, e, where(layout, e),
                         name_of(layout.elements().invariant(e)), state.value, unit, state.rate, unit);
    }
  }
  return {};
}

}  // namespace springnet::layers
