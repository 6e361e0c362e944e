// Simulation's changes of laws, neurons, rest lengths and masses, and the present values. All is checked before
// anything is changed.
#include <springnet/simulation.hpp>

#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "simulation/embedding_changes.hpp"
#include "simulation/implementation.hpp"

namespace springnet {
namespace {

using layers::Group;
using layers::Law;
using layers::Layout;
using ValueChange = Layout::ValueChange;

// Springs, or elements, of a layout.
struct Members {
  const Layout& layout;
  bool are_elements;

  [[nodiscard]] std::uint32_t group_number(std::uint32_t member) const {
    return are_elements ? layout.elements().group(member) : layout.laws().group[member];
  }
  [[nodiscard]] const Group& group(std::uint32_t member) const { return layout.laws().groups[group_number(member)]; }
  [[nodiscard]] std::uint32_t row(std::uint32_t member) const {
    return are_elements ? layout.elements().row(member) : layout.laws().row[member];
  }
  [[nodiscard]] double value(std::uint32_t member, std::size_t column) const {
    return group(member).columns[column][row(member)];
  }
  [[nodiscard]] std::string name(std::uint32_t member) const {
    return fmt::format("{} {}", are_elements ? "element" : "spring", member);
  }
};

[[noreturn]] void refuse(const std::string& text) { throw Error(ErrorKind::input, text); }

void check_count(std::size_t values, std::size_t members, std::string_view what) {
  if (values != 1 && values != members)
    refuse(fmt::format("{} values for {} {}: give one for all, or one each", values, members, what));
}

[[noreturn]] void refuse_name(const std::string& whose, std::string_view what, std::string_view name,
                              const std::vector<std::string>& known) {
  const std::string nearest = suggestion(name, known);
  refuse(fmt::format("{} has no {} '{}'; {}", whose, what, printable(std::string(name)),
                     known.empty() ? fmt::format("it has no {}s", what)
                                   : fmt::format("{}{}its {}s: {}", nearest, nearest.empty() ? "" : "; ", what,
                                                 fmt::join(known, ", "))));
}

// What of a law a name means: its parameter or its input.
struct Named {
  std::size_t column = 0;
  std::size_t law = 0;  // 0: spring function
  const springnet_parameter* declared = nullptr;
};

Named find_named(const Members& members, std::uint32_t member, ComponentKind kind, std::string_view name, bool input) {
  if (kind != ComponentKind::spring_function && kind != ComponentKind::viscosity_function)
    refuse(fmt::format("springs and elements have a spring function and a viscosity function, no {}", name_of(kind)));
  Named found;
  found.law = kind == ComponentKind::spring_function ? 0 : 1;
  const Law& law = *members.group(member).laws()[found.law];
  if (!law) refuse(fmt::format("{} has no {}", members.name(member), name_of(kind)));
  const springnet_component& description = *law.component->description;
  const springnet_law& functions = law.component->law();
  const std::size_t count = input ? law.input_count : law.parameter_count;
  std::vector<std::string> known;
  for (std::size_t k = 0; k < count; ++k) {
    const springnet_parameter* const declared = input ? functions.inputs[k] : description.parameters[k];
    if (declared->name == name) {
      found.column = (input ? law.first_input_column : law.first_column) + k;
      found.declared = declared;
      return found;
    }
    known.emplace_back(declared->name);
  }
  refuse_name(fmt::format("{}: its {} '{}'", members.name(member), name_of(kind), law.component->id()),
              input ? "input" : "parameter", name, known);
}

// The same for a list of members, of which most have the same laws.
class NameSearch {
 public:
  NameSearch(const Members& members, ComponentKind kind, std::string_view name, bool input)
      : members_(members), kind_(kind), name_(name), input_(input) {}
  const Named& of(std::uint32_t member) {
    const std::uint32_t group = members_.group_number(member);
    if (!known_ || group != group_) {
      known_ = find_named(members_, member, kind_, name_, input_);
      group_ = group;
    }
    return *known_;
  }

 private:
  const Members& members_;
  ComponentKind kind_;
  std::string_view name_;
  bool input_;
  std::optional<Named> known_;
  std::uint32_t group_ = 0;
};

void check_declared(const Members& members, std::uint32_t member, const Named& named, double value) {
  const std::string wrong = check_value(*named.declared, value);
  if (wrong.empty()) return;
  const Law& law = *members.group(member).laws()[named.law];
  refuse(fmt::format("{}: '{}' of its {} '{}' {}", members.name(member), named.declared->name,
                     name_of(law.component->kind()), law.component->id(), wrong));
}

// Rest length or reference.
void check_reference(const Members& members, std::uint32_t member, double value) {
  const char* const what = members.are_elements ? "reference" : "rest length";
  if (!std::isfinite(value) || (!members.are_elements && value < 0.0))
    refuse(fmt::format("{}: the {} must be {}, is {}", members.name(member), what,
                       members.are_elements ? "a finite number" : "0 m or more", value));
  for (const Law* const law : members.group(member).laws())
    if (law->can(SPRINGNET_DIVIDES_BY_REFERENCE) && !(value > 0.0))
      refuse(fmt::format("{}: {} '{}' divides by the {}, which cannot be {}; give one above 0", members.name(member),
                         name_of(law->component->kind()), law->component->id(), what, value));
}

void set(Layout& layout, bool of_elements, std::uint32_t member, const ValueChange& change) {
  if (of_elements)
    layout.set_element_value(member, change);
  else
    layout.set_spring_value(member, change);
}

void set_parameters(Engine& engine, const Members& members, const std::vector<std::uint32_t>& list, ComponentKind kind,
                    std::string_view name, const std::vector<double>& values) {
  check_count(values.size(), list.size(), members.are_elements ? "elements" : "springs");
  Layout& layout = engine.model().layout;
  NameSearch names(members, kind, name, false);
  std::vector<ValueChange> changes;
  changes.reserve(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Named& named = names.of(list[i]);
    ValueChange change{named.column, values[values.size() == 1 ? 0 : i], named.law, {}};
    check_declared(members, list[i], named, change.value);
    try {
      change.prepared = layout.prepare(members.group(list[i]), members.row(list[i]), change);
    } catch (const Error& error) {
      throw Error(error.kind(), fmt::format("{}: {}", members.name(list[i]), error.what()));
    }
    changes.push_back(std::move(change));
  }
  for (std::size_t i = 0; i < list.size(); ++i) set(layout, members.are_elements, list[i], changes[i]);
  if (!list.empty()) engine.laws_changed();
}

void set_inputs(Engine& engine, const Members& members, const std::vector<std::uint32_t>& list, ComponentKind kind,
                std::string_view name, const std::vector<double>& values) {
  check_count(values.size(), list.size(), members.are_elements ? "elements" : "springs");
  Layout& layout = engine.model().layout;
  const auto value_of = [&](std::size_t i) { return values[values.size() == 1 ? 0 : i]; };
  NameSearch names(members, kind, name, true);
  for (std::size_t i = 0; i < list.size(); ++i) check_declared(members, list[i], names.of(list[i]), value_of(i));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::size_t column = names.of(list[i]).column;
    if (members.are_elements)
      layout.set_element_input(list[i], column, value_of(i));
    else
      layout.set_spring_input(list[i], column, value_of(i));
  }
  if (!list.empty()) engine.laws_changed();
}

void set_reference_values(Engine& engine, const Members& members, const std::vector<std::uint32_t>& list,
                          const std::vector<double>& values) {
  check_count(values.size(), list.size(), members.are_elements ? "elements" : "springs");
  const auto value_of = [&](std::size_t i) { return values[values.size() == 1 ? 0 : i]; };
  for (std::size_t i = 0; i < list.size(); ++i) check_reference(members, list[i], value_of(i));
  for (std::size_t i = 0; i < list.size(); ++i)
    set(engine.model().layout, members.are_elements, list[i], {0, value_of(i), 0, {}});
  if (!list.empty()) engine.laws_changed();
}

std::size_t neuron_parameter_of(const Layout& layout, NodeIndex node, std::uint32_t engine_node,
                                std::string_view name) {
  const springnet_component& neuron = *layout.laws().neurons[layout.neuron_kind()[engine_node]].component->description;
  if (const std::ptrdiff_t index = parameter_index(neuron, name); index >= 0) return static_cast<std::size_t>(index);
  std::vector<std::string> known;
  for (std::uint32_t k = 0; k < neuron.parameter_count; ++k) known.emplace_back(neuron.parameters[k]->name);
  refuse_name(fmt::format("node {}: its neuron '{}'", node, neuron.id), "parameter", name, known);
}

}  // namespace

void Simulation::set_parameter(const std::vector<SpringIndex>& springs, ComponentKind law, std::string_view parameter,
                               const std::vector<double>& values) {
  for (const SpringIndex s : springs) impl_->check_spring(s);
  Engine& engine = impl_->between_steps().engine;
  set_parameters(engine, {engine.model().layout, false}, springs, law, parameter, values);
}
void Simulation::set_element_parameter(const std::vector<ElementIndex>& elements, ComponentKind law,
                                       std::string_view parameter, const std::vector<double>& values) {
  for (const ElementIndex e : elements) impl_->check_element(e);
  Engine& engine = impl_->between_steps().engine;
  set_parameters(engine, {engine.model().layout, true}, elements, law, parameter, values);
}
void Simulation::set_law_input(const std::vector<SpringIndex>& springs, ComponentKind law, std::string_view input,
                               const std::vector<double>& values) {
  for (const SpringIndex s : springs) impl_->check_spring(s);
  Engine& engine = impl_->between_steps().engine;
  set_inputs(engine, {engine.model().layout, false}, springs, law, input, values);
}
void Simulation::set_element_input(const std::vector<ElementIndex>& elements, ComponentKind law, std::string_view input,
                                   const std::vector<double>& values) {
  for (const ElementIndex e : elements) impl_->check_element(e);
  Engine& engine = impl_->between_steps().engine;
  set_inputs(engine, {engine.model().layout, true}, elements, law, input, values);
}
void Simulation::set_rest_lengths(const std::vector<SpringIndex>& springs, const std::vector<double>& values) {
  for (const SpringIndex s : springs) impl_->check_spring(s);
  Engine& engine = impl_->between_steps().engine;
  set_reference_values(engine, {engine.model().layout, false}, springs, values);
}
void Simulation::set_references(const std::vector<ElementIndex>& elements, const std::vector<double>& values) {
  const layers::ElementLayout& layout = impl_->engine.model().layout.elements();
  for (const ElementIndex e : elements) {
    impl_->check_element(e);
    if (reads_several(layout.invariant(e)))
      refuse(
          fmt::format("element {} ({}) has no reference of its own: its laws read several scalars of the nodes' "
                      "positions at rest, which stay as they are",
                      e, name_of(layout.invariant(e))));
  }
  Engine& engine = impl_->between_steps().engine;
  set_reference_values(engine, {engine.model().layout, true}, elements, values);
}

void Simulation::set_neuron_parameter(const std::vector<NodeIndex>& nodes, std::string_view parameter,
                                      const std::vector<double>& values) {
  Engine& engine = impl_->between_steps().engine;
  Layout& layout = engine.model().layout;
  check_count(values.size(), nodes.size(), "nodes");
  const auto value_of = [&](std::size_t i) { return values[values.size() == 1 ? 0 : i]; };
  std::vector<std::uint32_t> engine_nodes;
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::uint32_t k = engine_nodes.emplace_back(impl_->engine_node(nodes[i]));
    indices.push_back(neuron_parameter_of(layout, nodes[i], k, parameter));
    const springnet_component& neuron = *layout.laws().neurons[layout.neuron_kind()[k]].component->description;
    if (const std::string wrong = check_value(*neuron.parameters[indices.back()], value_of(i)); !wrong.empty())
      refuse(fmt::format("node {}: '{}' of its neuron '{}' {}", nodes[i], parameter, neuron.id, wrong));
  }
  const std::span<const double> all(values);
  for (std::size_t begin = 0, end = 0; begin < nodes.size(); begin = end) {
    while (end < nodes.size() && indices[end] == indices[begin]) ++end;
    layout.set_neuron_parameter(std::span(engine_nodes).subspan(begin, end - begin), indices[begin],
                                values.size() == 1 ? all : all.subspan(begin, end - begin));
  }
  if (!nodes.empty()) engine.laws_changed();
}

void Simulation::set_masses(const std::vector<NodeIndex>& nodes, const std::vector<double>& values) {
  Engine& engine = impl_->between_steps().engine;
  check_count(values.size(), nodes.size(), "nodes");
  const auto value_of = [&](std::size_t i) { return values[values.size() == 1 ? 0 : i]; };
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    static_cast<void>(impl_->engine_node(nodes[i]));
    if (!(value_of(i) > 0.0 && std::isfinite(value_of(i))))
      refuse(fmt::format("node {}: the mass must be a finite number above 0 kg, is {}", nodes[i], value_of(i)));
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) engine.model().set_mass(impl_->engine_node(nodes[i]), value_of(i));
  if (!nodes.empty()) engine.laws_changed();
}

double Simulation::parameter(SpringIndex spring, ComponentKind law, std::string_view parameter) const {
  impl_->check_spring(spring);
  const Members members{impl_->engine.model().layout, false};
  return members.value(spring, find_named(members, spring, law, parameter, false).column);
}
double Simulation::element_parameter(ElementIndex element, ComponentKind law, std::string_view parameter) const {
  impl_->check_element(element);
  const Members members{impl_->engine.model().layout, true};
  return members.value(element, find_named(members, element, law, parameter, false).column);
}
double Simulation::neuron_parameter(NodeIndex node, std::string_view parameter) const {
  const std::uint32_t k = impl_->engine_node(node);
  const Layout& layout = impl_->engine.model().layout;
  const std::size_t index = neuron_parameter_of(layout, node, k, parameter);
  return layout.laws().neurons[layout.neuron_kind()[k]].parameters[index];
}
double Simulation::rest_length(SpringIndex spring) const {
  impl_->check_spring(spring);
  return Members{impl_->engine.model().layout, false}.value(spring, 0);
}
double Simulation::reference(ElementIndex element) const {
  impl_->check_element(element);
  return impl_->engine.model().layout.elements().reference(element);
}
double Simulation::mass(NodeIndex node) const { return impl_->engine.model().mass[impl_->engine_node(node)]; }

std::size_t Simulation::remove_elements(const std::vector<ElementIndex>& elements) {
  for (const ElementIndex e : elements) impl_->check_element(e);
  return impl_->between_steps().engine.topology().remove_elements(elements);
}

void Simulation::remove_nodes(const std::vector<NodeIndex>& nodes) {
  Model& model = impl_->changed_state();
  std::vector<std::uint32_t> removed;
  for (const NodeIndex node : nodes) {
    const std::uint32_t k = removed.emplace_back(impl_->engine_node(node));
    for (const RigidConnections::Rod& rod : model.rigid.rods())
      if (rod.first == k || rod.second == k)
        refuse(
            fmt::format("node {} has a rigid connection, which cannot be removed; fix the node in place of it", node));
  }
  impl_->engine.topology().remove_nodes(removed);
  for (const std::uint32_t k : removed) springnet::set_fixed(model, k, true);
}

}  // namespace springnet
