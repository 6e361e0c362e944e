#include "layers/parameters/sets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include <springnet/error.hpp>

#include "layers/law_pair.hpp"
#include "plugin_host/call.hpp"

namespace springnet::layers {
namespace {

using Kind = ParameterSet::Kind;

bool is_meant(const ParameterSet& set, const Component& component) {
  return set.component.empty() || component.id() == set.component;
}

std::optional<std::uint32_t> parameter_number(const Component& component, std::string_view name) {
  const springnet_component& description = *component.description;
  for (std::uint32_t i = 0; i < description.parameter_count; ++i)
    if (name == description.parameters[i]->name) return i;
  return std::nullopt;
}

[[noreturn]] void lacks(const Component& component, std::string_view by) {
  throw Error(ErrorKind::plugin,
              fmt::format("{} does not give its derivative by {}; build it with an SDK of ABI 2.1 or newer",
                          full_name(component), by));
}

// The slots of a column: of the forces, then of `states` states.
std::uint32_t slots_of(SetsOfGroup::OfLaw& law, std::size_t column, bool is_parameter, const sdk::JacobianLayout& rows,
                       std::size_t states) {
  std::vector<SetsOfGroup::Slot>& slots = law.slots;
  for (std::uint32_t i = 0; i < slots.size(); ++i)
    if (slots[i].row == rows.force() && slots[i].column == column && slots[i].is_parameter == is_parameter) return i;
  const auto first = static_cast<std::uint32_t>(slots.size());
  for (std::size_t i = 0; i < rows.invariants; ++i) slots.push_back({rows.force(i), column, is_parameter});
  for (std::size_t j = 0; j < states; ++j) slots.push_back({rows.state_row(j), column, false});
  return first;
}

}  // namespace

ResolvedSets::ResolvedSets(const Layout& layout, const std::vector<ParameterSet>& sets, bool with_states)
    : sets_(sets), found_(sets.size(), 0), with_states_(with_states) {
  const CompiledLaws& laws = layout.laws();
  springs_.resize(laws.groups.size());
  elements_.resize(laws.groups.size());
  neurons_.resize(laws.neurons.size());
  std::vector<std::uint8_t> has_springs(laws.groups.size(), 0), has_elements(laws.groups.size(), 0);
  for (std::size_t s = 0; s < layout.spring_count(); ++s) has_springs[laws.group[s]] = 1;
  for (std::size_t e = 0; e < layout.elements().count(); ++e) has_elements[laws.element_group[e]] = 1;
  for (std::uint32_t i = 0; i < sets_.size(); ++i) {
    const ParameterSet& set = sets_[i];
    if (set.kind == Kind::input && set.input >= laws.inputs.size())
      throw Error(ErrorKind::plugin, fmt::format("input {} of a parameter set does not exist: the network has {}",
                                                 set.input, laws.inputs.size()));
    for (std::size_t g = 0; g < laws.groups.size(); ++g) {
      for (std::size_t law = 0; law < 2; ++law) {
        if (has_springs[g] != 0 && (set.is_one() || !set.of_elements)) resolve_law(i, laws.groups[g], law, springs_[g]);
        if (has_elements[g] != 0 && (set.is_one() || set.of_elements))
          resolve_law(i, laws.groups[g], law, elements_[g]);
      }
    }
    for (std::size_t k = 0; k < laws.neurons.size(); ++k) resolve_neuron(i, laws.neurons[k], neurons_[k]);
    if (found_[i] == 0 && !set.is_one()) refuse(set, layout);
  }
}

void ResolvedSets::resolve_law(std::uint32_t number, const Group& group, std::size_t which, SetsOfGroup& out) {
  const ParameterSet& set = sets_[number];
  const Law& law = *group.laws()[which];
  if (!law || set.kind == Kind::mass || set.kind == Kind::neuron) return;
  if ((set.kind == Kind::spring && which != 0) || (set.kind == Kind::viscosity && which != 1)) return;
  const sdk::JacobianLayout jacobian = jacobian_of(law);
  SetsOfGroup::OfLaw& own = out.laws[which];
  const std::size_t states = with_states_ ? law.state_count : 0;
  const bool has_all = law.can(SPRINGNET_HAS_ALL_DERIVATIVES);
  const auto add = [&](std::size_t column, std::string_view by, std::uint32_t signal_column = 0,
                       std::uint32_t scalar = 0) {
    if (!has_all) lacks(*law.component, by);
    own.entries.push_back({number, slots_of(own, column, false, jacobian, states), signal_column, scalar});
    found_[number] = 1;
  };
  switch (set.kind) {
    case Kind::reference:
      if (law.scalar_count == 0) add(jacobian.reference(), "its reference value");
      for (std::uint32_t j = 0; j < law.scalar_count; ++j)
        if (group.scalars.scalar[law.scalar[j]].dimension() > 0)
          add(jacobian.reference(j), "its reference values", 0, j);
      // The direction is a unit vector by the edges, which grow.
      for (std::uint32_t c = 0; c < 3 && law.reads_direction; ++c)
        add(jacobian.direction(c), "the direction of the material", 0, law.scalar_count + c);
      break;
    case Kind::input:
      for (std::size_t i = 0; i < law.input_count; ++i)
        add(jacobian.input(i), "its inputs", static_cast<std::uint32_t>(law.first_input_column + i));
      break;
    case Kind::time:
      if (law.can(SPRINGNET_READS_TIME)) add(jacobian.time(), "the time");
      break;
    default: {
      if (!is_meant(set, *law.component)) return;
      const std::optional<std::uint32_t> parameter = parameter_number(*law.component, set.parameter);
      if (!parameter) return;
      if (has_all) return add(jacobian.parameter(*parameter), set.parameter);
      if (!law.can(SPRINGNET_HAS_PARAMETER_DERIVATIVES) || states > 0)
        lacks(*law.component, fmt::format("'{}'", set.parameter));
      own.entries.push_back({number, slots_of(own, *parameter, true, jacobian, 0)});
      found_[number] = 1;
    }
  }
}

void ResolvedSets::resolve_neuron(std::uint32_t number, const NeuronKind& kind, std::vector<NeuronEntry>& out) {
  using By = NeuronEntry::By;
  const ParameterSet& set = sets_[number];
  NeuronEntry entry{number, By::mass, 0};
  if (set.kind == Kind::time) {
    entry.by = By::time;
  } else if (set.kind == Kind::neuron) {
    if (!is_meant(set, *kind.component)) return;
    const std::optional<std::uint32_t> parameter = parameter_number(*kind.component, set.parameter);
    if (!parameter) return;
    entry.by = By::parameter;
    entry.parameter = *parameter;
  } else if (set.kind != Kind::mass) {
    return;
  }
  if ((kind.component->description->capabilities & SPRINGNET_HAS_PARAMETER_DERIVATIVES) == 0)
    lacks(*kind.component, entry.by == By::mass ? "the mass" : entry.by == By::time ? "the time" : set.parameter);
  out.push_back(entry);
  found_[number] = 1;
}

void ResolvedSets::refuse(const ParameterSet& set, const Layout& layout) const {
  std::vector<std::string> known;
  const auto note = [&](const Component& component) {
    for (std::uint32_t i = 0; i < component.description->parameter_count; ++i)
      known.push_back(fmt::format("{}.{}", component.id(), component.description->parameters[i]->name));
  };
  if (set.kind == Kind::neuron) {
    for (const NeuronKind& kind : layout.laws().neurons) note(*kind.component);
  } else {
    for (const Group& group : layout.laws().groups)
      if (const Law& law = *group.laws()[set.kind == Kind::viscosity ? 1 : 0]) note(*law.component);
  }
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  std::string list;
  for (const std::string& each : known) list += (list.empty() ? "" : ", ") + each;
  throw Error(ErrorKind::plugin,
              fmt::format("no {} has {}{}{}",
                          set.kind == Kind::neuron ? "node"
                          : set.of_elements        ? "element"
                                                   : "spring",
                          set.kind == Kind::reference ? "a law" : fmt::format("a parameter '{}'", set.parameter),
                          set.component.empty() ? "" : fmt::format(" of '{}'", set.component),
                          list.empty() ? "" : fmt::format("; the network has {}", list)));
}

}  // namespace springnet::layers
