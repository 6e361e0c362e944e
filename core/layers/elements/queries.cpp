#include "layers/elements/queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "layers/elements/blocks.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

const Group& group_of(const Layout& layout, std::uint32_t element) {
  return layout.laws().groups[layout.elements().group(element)];
}

}  // namespace

springnet_status evaluate_element(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                  std::uint32_t element, const ElementState& state, const PairOutputs& out,
                                  springnet_message& message) {
  const profile::Tile measured;
  const profile::Part part("elements");
  const std::uint32_t group = layout.elements().group(element);
  const std::uint32_t place = layout.internal().has(group) ? layout.internal().of_element(element) : 0;
  const LawBatch batch{group_of(layout, element),
                       1,
                       {nullptr, layout.elements().row(element)},
                       &state.value,
                       &state.rate,
                       nullptr,
                       {layout.internal(), group, nodes, &place},
                       nullptr,
                       {CalledMembers::Are::elements, 1, 1, &element}};
  return evaluate_laws(batch, set, time, out, message);
}

springnet_status evaluate_several_element(const Layout& layout, InstructionSet set, double time,
                                          const NodeArrays& nodes, std::uint32_t element, SeveralWanted wanted,
                                          SeveralQuery& out, springnet_message& message) {
  const profile::Tile measured;
  const profile::Part part("elements");
  const Group& group = group_of(layout, element);
  GatheredMembers gathered;
  const SeveralMembers& members = gathered.gather(layout.elements(), 1, [element](std::size_t) { return element; });
  // Rates are always computed: some who ask read them.
  kernels_for(set).several.geometry(group.scalars, members.corners, members.reference, nodes, true, out.geometry);
  return evaluate_several(group, members, out.geometry, set, time, wanted, out.answers, message);
}

namespace {

// "nodes 1, 2 and 3"; of an enclosure only their number.
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
  return {nearest_turn(value_invariant(invariant), geometry.value, elements.reference(element)), geometry.rate};
}

double element_force(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                     std::uint32_t element) {
  if (reads_several(layout.elements().invariant(element))) return std::numeric_limits<double>::quiet_NaN();
  PairAnswers<1> answers;
  springnet_message message{};
  if (evaluate_element(layout, set, time, nodes, element, element_state(layout, nodes, element),
                       answers.outputs(false, false), message) != SPRINGNET_OK)
    return std::numeric_limits<double>::quiet_NaN();
  return element_force(group_of(layout, element), answers, 0, false).force;
}

namespace {

// Stored by the laws of one element that have an energy, J; nan if one fails.
double several_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                      std::uint32_t element) {
  const auto query = std::make_unique_for_overwrite<SeveralQuery>();
  springnet_message message{};
  if (evaluate_several_element(layout, set, time, nodes, element, SeveralWanted::forces_and_energies, *query,
                               message) != SPRINGNET_OK)
    return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (std::size_t k = 0; k < 2; ++k)
    if (group_of(layout, element).laws()[k]->can(SPRINGNET_HAS_ENERGY)) sum += query->answers.energy[k][0];
  return sum;
}

}  // namespace

double element_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes) {
  double sum = 0.0;
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e) {
    if (!layout.elements().alive(e) || !group_of(layout, e).can(SPRINGNET_HAS_ENERGY)) continue;
    if (reads_several(layout.elements().invariant(e))) {
      sum += several_energy(layout, set, time, nodes, e);
      continue;
    }
    double force = 0.0, energy[2] = {0.0, 0.0};
    PairOutputs out{};  // of these laws alone
    for (std::size_t k = 0; k < out.size(); ++k) {
      if (!group_of(layout, e).laws()[k]->can(SPRINGNET_HAS_ENERGY)) continue;
      out[k].force = &force;
      out[k].energy = &energy[k];
    }
    springnet_message message{};
    if (evaluate_element(layout, set, time, nodes, e, element_state(layout, nodes, e), out, message) != SPRINGNET_OK)
      return std::numeric_limits<double>::quiet_NaN();
    sum += energy[0] + energy[1];
  }
  return sum;
}

std::vector<std::uint32_t> rupturing_elements(const Layout& layout) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e) {
    if (layout.elements().alive(e) && group_of(layout, e).can(SPRINGNET_HAS_RUPTURE)) found.push_back(e);
  }
  return found;
}

springnet_status element_margins(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                 const std::vector<std::uint32_t>& elements, double* margins,
                                 springnet_message& message) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const std::uint32_t e = elements[i];
    const std::array<const Law*, 2> laws = group_of(layout, e).laws();
    if (reads_several(layout.elements().invariant(e))) {
      const auto query = std::make_unique_for_overwrite<SeveralQuery>();
      const springnet_status status =
          evaluate_several_element(layout, set, time, nodes, e, SeveralWanted::margins, *query, message);
      if (status != SPRINGNET_OK) return status;
      margins[i] = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < 2; ++k)
        if (laws[k]->can(SPRINGNET_HAS_RUPTURE)) margins[i] = lesser(margins[i], query->answers.margin[k][0]);
      continue;
    }
    double force[2], margin[2];
    PairOutputs out{};
    for (std::size_t k = 0; k < laws.size(); ++k) {
      margin[k] = std::numeric_limits<double>::infinity();
      if (!laws[k]->can(SPRINGNET_HAS_RUPTURE)) continue;
      out[k].force = &force[k];
      out[k].margin = &margin[k];
    }
    const springnet_status status =
        evaluate_element(layout, set, time, nodes, e, element_state(layout, nodes, e), out, message);
    if (status != SPRINGNET_OK) return status;
    margins[i] = lesser(margin[0], margin[1]);
  }
  return SPRINGNET_OK;
}

namespace {

std::string at_element(const Layout& layout, std::uint32_t element, const ElementState& state) {
  const Invariant invariant = value_invariant(layout.elements().invariant(element));
  const std::string_view unit = unit_of(invariant);
  return fmt::format(" for element {} ({}; {} {} {}, rate {} {}/s)", element, where(layout, element),
                     name_of(invariant), state.value, unit, state.rate, unit);
}

// Of an element whose laws read several scalars: the first law that failed or answered a number that is not finite.
std::string explain_several(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                            std::uint32_t element, Requested requested) {
  const Group& group = group_of(layout, element);
  const SeveralWanted wanted = requested == Requested::forces_and_derivatives ? SeveralWanted::tangent
                               : requested == Requested::forces_and_energies  ? SeveralWanted::forces_and_energies
                                                                              : SeveralWanted::forces;
  for (std::size_t k = 0; k < 2; ++k) {
    const Law& law = *group.laws()[k];
    if (!law) continue;
    Group alone = group;
    (k == 0 ? alone.viscosity : alone.spring) = {};
    GatheredMembers gathered;
    const SeveralMembers& members = gathered.gather(layout.elements(), 1, [element](std::size_t) { return element; });
    const auto query = std::make_unique_for_overwrite<SeveralQuery>();
    kernels_for(set).several.geometry(alone.scalars, members.corners, members.reference, nodes, true, query->geometry);
    springnet_message message{};
    const springnet_status status =
        evaluate_several(alone, members, query->geometry, set, time, wanted, query->answers, message);
    LawAnswer answer;
    for (std::size_t i = 0; status == SPRINGNET_OK && i < law.scalar_count; ++i) {
      const std::size_t s = law.scalar[i];
      if (!law.reads[i]) continue;
      answer.force += query->answers.force[k][s][0];
      for (std::size_t j = 0; wanted == SeveralWanted::tangent && j < law.scalar_count; ++j) {
        if (!law.reads[j]) continue;
        answer.by_q += query->answers.by_value[k][max_scalars * s + law.scalar[j]][0];
        if (law.reads_rate) answer.by_rate += query->answers.by_rate[k][max_scalars * s + law.scalar[j]][0];
      }
    }
    if (wanted == SeveralWanted::forces_and_energies && law.can(SPRINGNET_HAS_ENERGY))
      answer.energy = query->answers.energy[k][0];
    std::string what = wrong_answer(*law.component, status, answer, message);
    if (!what.empty()) return what;
  }
  return {};
}

}  // namespace

std::string explain_element_failure(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                    Requested requested) {
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e) {
    if (!layout.elements().alive(e)) continue;
    const ElementState state = element_state(layout, nodes, e);
    const std::array<const Law*, 2> laws = group_of(layout, e).laws();
    if (reads_several(layout.elements().invariant(e))) {
      const std::string what = explain_several(layout, set, time, nodes, e, requested);
      if (!what.empty()) return what + at_element(layout, e, state);
      continue;
    }
    for (std::size_t k = 0; k < laws.size(); ++k) {
      if (!*laws[k]) continue;
      LawAnswer answer;
      PairOutputs out{};  // of this law alone
      out[k] = answer.outputs(*laws[k], requested);
      springnet_message message{};
      const springnet_status status = evaluate_element(layout, set, time, nodes, e, state, out, message);
      const std::string what = wrong_answer(*laws[k]->component, status, answer, message);
      if (!what.empty()) return what + at_element(layout, e, state);
    }
  }
  return {};
}

}  // namespace springnet::layers
