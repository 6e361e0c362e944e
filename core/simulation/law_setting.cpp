#include "simulation/law_setting.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "simulation/embedding_changes.hpp"
#include "simulation/engine.hpp"

namespace springnet {
namespace {

using layers::Group;
using layers::Law;
using layers::Layout;
using ValueChange = Layout::ValueChange;

[[noreturn]] void refuse_change(const std::string& text) { throw Error(ErrorKind::input, text); }

void check_count(std::size_t values, std::size_t members, std::string_view what) {
  if (values != 1 && values != members)
    refuse_change(fmt::format("{} values for {} {}: give one for all, or one each", values, members, what));
}
void check_count(const Members& members, std::size_t values, std::size_t count) {
  check_count(values, count, members.are_elements ? "elements" : "springs");
}

double one_of(const std::vector<double>& values, std::size_t i) { return values[values.size() == 1 ? 0 : i]; }

[[noreturn]] void refuse_name(const std::string& whose, std::string_view what, std::string_view name,
                              const std::vector<std::string>& known) {
  const std::string nearest = suggestion(name, known);
  refuse_change(fmt::format("{} has no {} '{}'; {}", whose, what, printable(std::string(name)),
                            known.empty() ? fmt::format("it has no {}s", what)
                                          : fmt::format("{}{}its {}s: {}", nearest, nearest.empty() ? "" : "; ", what,
                                                        fmt::join(known, ", "))));
}

// What of a law a name means.
struct Named {
  std::size_t column = 0;
  std::size_t law = 0;  // 0: spring function
  const springnet_parameter* declared = nullptr;
};

std::size_t law_index(ComponentKind kind) {
  if (kind != ComponentKind::spring_function && kind != ComponentKind::viscosity_function)
    refuse_change(
        fmt::format("springs and elements have a spring function and a viscosity function, no {}", name_of(kind)));
  return kind == ComponentKind::spring_function ? 0 : 1;
}

std::optional<Named> look_up(const Law& law, std::size_t index, const LawValue& value) {
  const springnet_component& description = *law.component->description;
  const std::size_t count = value.is_input ? law.input_count : law.parameter_count;
  for (std::size_t k = 0; k < count; ++k) {
    const springnet_parameter* const declared =
        value.is_input ? law.component->law().inputs[k] : description.parameters[k];
    if (declared->name == value.name)
      return Named{(value.is_input ? law.first_input_column : law.first_column) + k, index, declared};
  }
  return std::nullopt;
}

Named find_named(const Members& members, std::uint32_t member, const LawValue& value) {
  const std::size_t index = law_index(value.law);
  const Law& law = *members.group(member).laws()[index];
  if (!law) refuse_change(fmt::format("{} has no {}", members.name(member), name_of(value.law)));
  if (const std::optional<Named> found = look_up(law, index, value)) return *found;
  std::vector<std::string> known;
  for (std::size_t k = 0; k < (value.is_input ? law.input_count : law.parameter_count); ++k)
    known.emplace_back(
        (value.is_input ? law.component->law().inputs[k] : law.component->description->parameters[k])->name);
  refuse_name(fmt::format("{}: its {} '{}'", members.name(member), name_of(value.law), law.component->id()),
              value.is_input ? "input" : "parameter", value.name, known);
}

// The same for a list of members, of which most have the same laws.
class NameSearch {
 public:
  NameSearch(const Members& members, const LawValue& value) : members_(members), value_(value) {}
  const Named& of(std::uint32_t member) {
    const std::uint32_t group = members_.group_number(member);
    if (known_.declared == nullptr || group != group_) {
      known_ = find_named(members_, member, value_);
      group_ = group;
    }
    return known_;
  }

 private:
  const Members& members_;
  const LawValue& value_;
  Named known_;
  std::uint32_t group_ = 0;
};

void set(Layout& layout, bool of_elements, std::uint32_t member, const ValueChange& change) {
  if (of_elements)
    layout.set_element_value(member, change);
  else
    layout.set_spring_value(member, change);
}

void set_inputs(Layout& layout, const Members& members, const std::vector<std::uint32_t>& list, const LawValue& what,
                const std::vector<double>& values) {
  NameSearch names(members, what);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::size_t column = names.of(list[i]).column;
    if (members.are_elements)
      layout.set_element_input(list[i], column, one_of(values, i));
    else
      layout.set_spring_input(list[i], column, one_of(values, i));
  }
}

const springnet_component& neuron_of(const Layout& layout, NodeIndex node) {
  return *layout.laws().neurons[layout.neuron_kind()[layout.ordering().engine[node]]].component->description;
}

std::size_t neuron_parameter_of(const Layout& layout, NodeIndex node, std::string_view name) {
  const springnet_component& neuron = neuron_of(layout, node);
  if (const std::ptrdiff_t index = parameter_index(neuron, name); index >= 0) return static_cast<std::size_t>(index);
  std::vector<std::string> known;
  for (std::uint32_t k = 0; k < neuron.parameter_count; ++k) known.emplace_back(neuron.parameters[k]->name);
  refuse_name(fmt::format("node {}: its neuron '{}'", node, neuron.id), "parameter", name, known);
}

}  // namespace

std::string Members::name(std::uint32_t member) const {
  return fmt::format("{} {}", are_elements ? "element" : "spring", member);
}

double value_of(const Members& members, std::uint32_t member, const LawValue& value) {
  return members.value(member, find_named(members, member, value).column);
}

bool has_value(const Members& members, std::uint32_t member, const LawValue& value) {
  const std::size_t index = law_index(value.law);
  const Law& law = *members.group(member).laws()[index];
  return law && look_up(law, index, value);
}

void check_values(const Members& members, const std::vector<std::uint32_t>& list, const LawValue& what,
                  const std::vector<double>& values) {
  check_count(members, values.size(), list.size());
  NameSearch names(members, what);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Named& named = names.of(list[i]);
    const std::string wrong = check_value(*named.declared, one_of(values, i));
    if (wrong.empty()) continue;
    const Law& law = *members.group(list[i]).laws()[named.law];
    refuse_change(fmt::format("{}: '{}' of its {} '{}' {}", members.name(list[i]), named.declared->name,
                              name_of(law.component->kind()), law.component->id(), wrong));
  }
}

void set_values(Engine& engine, const Members& members, const std::vector<std::uint32_t>& list, const LawValue& what,
                const std::vector<double>& values) {
  check_values(members, list, what, values);
  if (list.empty()) return;
  Layout& layout = engine.model().layout;
  if (what.is_input) {
    set_inputs(layout, members, list, what, values);
    engine.laws_changed();
    return;
  }
  NameSearch names(members, what);
  std::vector<ValueChange> changes;
  changes.reserve(list.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Named& named = names.of(list[i]);
    ValueChange change{named.column, one_of(values, i), named.law, {}};
    try {
      change.prepared = layout.prepare(members.group(list[i]), members.row(list[i]), change);
    } catch (const Error& error) {
      throw Error(error.kind(), fmt::format("{}: {}", members.name(list[i]), error.what()));
    }
    changes.push_back(std::move(change));
  }
  for (std::size_t i = 0; i < list.size(); ++i) set(layout, members.are_elements, list[i], changes[i]);
  engine.laws_changed();
}

double reference_of(const Members& members, std::uint32_t member) {
  return members.are_elements ? members.layout.elements().reference(member) : members.value(member, 0);
}

void check_references(const Members& members, const std::vector<std::uint32_t>& list,
                      const std::vector<double>& values) {
  check_count(members, values.size(), list.size());
  const char* const what = members.are_elements ? "reference" : "rest length";
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double value = one_of(values, i);
    if (members.are_elements && reads_several(members.layout.elements().invariant(list[i])))
      refuse_change(
          fmt::format("{} ({}) has no reference of its own: its laws read several scalars of the nodes' positions "
                      "at rest, which stay as they are",
                      members.name(list[i]), name_of(members.layout.elements().invariant(list[i]))));
    if (!std::isfinite(value) || (!members.are_elements && value < 0.0))
      refuse_change(fmt::format("{}: the {} must be {}, is {}", members.name(list[i]), what,
                                members.are_elements ? "a finite number" : "0 m or more", value));
    for (const Law* const law : members.group(list[i]).laws())
      if (law->can(SPRINGNET_DIVIDES_BY_REFERENCE) && !(value > 0.0))
        refuse_change(fmt::format("{}: {} '{}' divides by the {}, which cannot be {}; give one above 0",
                                  members.name(list[i]), name_of(law->component->kind()), law->component->id(), what,
                                  value));
  }
}

void set_references(Engine& engine, const Members& members, const std::vector<std::uint32_t>& list,
                    const std::vector<double>& values) {
  check_references(members, list, values);
  for (std::size_t i = 0; i < list.size(); ++i)
    set(engine.model().layout, members.are_elements, list[i], {0, one_of(values, i), 0, {}});
  if (!list.empty()) engine.laws_changed();
}

void check_neurons(const Layout& layout, const std::vector<NodeIndex>& nodes, std::string_view parameter,
                   const std::vector<double>& values) {
  check_count(values.size(), nodes.size(), "nodes");
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const springnet_component& neuron = neuron_of(layout, nodes[i]);
    const std::size_t index = neuron_parameter_of(layout, nodes[i], parameter);
    if (const std::string wrong = check_value(*neuron.parameters[index], one_of(values, i)); !wrong.empty())
      refuse_change(fmt::format("node {}: '{}' of its neuron '{}' {}", nodes[i], parameter, neuron.id, wrong));
  }
}

void set_neurons(Engine& engine, const std::vector<NodeIndex>& nodes, std::string_view parameter,
                 const std::vector<double>& values) {
  Layout& layout = engine.model().layout;
  check_neurons(layout, nodes, parameter, values);
  std::vector<std::uint32_t> numbers;
  std::vector<std::size_t> indices;
  for (const NodeIndex node : nodes) {
    numbers.push_back(layout.ordering().engine[node]);
    indices.push_back(neuron_parameter_of(layout, node, parameter));
  }
  const std::span<const double> all(values);
  for (std::size_t begin = 0, end = 0; begin < nodes.size(); begin = end) {
    while (end < nodes.size() && indices[end] == indices[begin]) ++end;
    layout.set_neuron_parameter(std::span(numbers).subspan(begin, end - begin), indices[begin],
                                values.size() == 1 ? all : all.subspan(begin, end - begin));
  }
  if (!nodes.empty()) engine.laws_changed();
}

double neuron_value(const Layout& layout, NodeIndex node, std::string_view parameter) {
  return layout.laws()
      .neurons[layout.neuron_kind()[layout.ordering().engine[node]]]
      .parameters[neuron_parameter_of(layout, node, parameter)];
}

void check_masses(const std::vector<NodeIndex>& nodes, const std::vector<double>& values) {
  check_count(values.size(), nodes.size(), "nodes");
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (!(one_of(values, i) > 0.0 && std::isfinite(one_of(values, i))))
      refuse_change(
          fmt::format("node {}: the mass must be a finite number above 0 kg, is {}", nodes[i], one_of(values, i)));
}

void set_masses(Engine& engine, const std::vector<NodeIndex>& nodes, const std::vector<double>& values) {
  check_masses(nodes, values);
  Model& model = engine.model();
  for (std::size_t i = 0; i < nodes.size(); ++i)
    model.set_mass(model.layout.ordering().engine[nodes[i]], one_of(values, i));
  if (!nodes.empty()) engine.laws_changed();
}

void check_removal(const Engine& engine, const std::vector<NodeIndex>& nodes) {
  for (const NodeIndex node : nodes) {
    const std::uint32_t k = engine.model().layout.ordering().engine[node];
    for (const RigidConnections::Rod& rod : engine.model().rigid.rods())
      if (rod.first == k || rod.second == k)
        refuse_change(
            fmt::format("node {} has a rigid connection, which cannot be removed; fix the node in place of it", node));
  }
}

void remove_nodes(Engine& engine, const std::vector<NodeIndex>& nodes) {
  check_removal(engine, nodes);
  std::vector<std::uint32_t> removed;
  for (const NodeIndex node : nodes) removed.push_back(engine.model().layout.ordering().engine[node]);
  engine.topology().remove_nodes(removed);
  for (const std::uint32_t k : removed) set_fixed(engine.model(), k, true);
}

}  // namespace springnet
