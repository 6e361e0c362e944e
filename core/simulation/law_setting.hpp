// Changes of values that laws and neurons read, by their names: checked as where a network is built, then made. Numbers
// of springs, elements and nodes are the user's, and exist. Throw Error(input) before anything is changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/simulation.hpp>

#include "layers/layout.hpp"

namespace springnet {

class Engine;

// Springs, or elements, of a layout.
struct Members {
  const layers::Layout& layout;
  bool are_elements;

  [[nodiscard]] std::uint32_t group_number(std::uint32_t member) const {
    return are_elements ? layout.elements().group(member) : layout.laws().group[member];
  }
  [[nodiscard]] const layers::Group& group(std::uint32_t member) const {
    return layout.laws().groups[group_number(member)];
  }
  [[nodiscard]] std::uint32_t row(std::uint32_t member) const {
    return are_elements ? layout.elements().row(member) : layout.laws().row[member];
  }
  [[nodiscard]] double value(std::uint32_t member, std::size_t column) const {
    return group(member).columns[column][row(member)];
  }
  [[nodiscard]] std::string name(std::uint32_t member) const;
};

// A parameter or an input of a law.
struct LawValue {
  ComponentKind law = ComponentKind::spring_function;
  std::string_view name;
  bool is_input = false;
};
[[nodiscard]] double value_of(const Members& members, std::uint32_t member, const LawValue& value);
// Whether the member has such a law, and that such a parameter or input.
[[nodiscard]] bool has_value(const Members& members, std::uint32_t member, const LawValue& value);

// values: one for all, or one each.
void check_values(const Members& members, const std::vector<std::uint32_t>& list, const LawValue& what,
                  const std::vector<double>& values);
void set_values(Engine& engine, const Members& members, const std::vector<std::uint32_t>& list, const LawValue& what,
                const std::vector<double>& values);
// Rest lengths (m), or references.
[[nodiscard]] double reference_of(const Members& members, std::uint32_t member);
void check_references(const Members& members, const std::vector<std::uint32_t>& list,
                      const std::vector<double>& values);
void set_references(Engine& engine, const Members& members, const std::vector<std::uint32_t>& list,
                    const std::vector<double>& values);

void check_neurons(const layers::Layout& layout, const std::vector<NodeIndex>& nodes, std::string_view parameter,
                   const std::vector<double>& values);
void set_neurons(Engine& engine, const std::vector<NodeIndex>& nodes, std::string_view parameter,
                 const std::vector<double>& values);
[[nodiscard]] double neuron_value(const layers::Layout& layout, NodeIndex node, std::string_view parameter);
void check_masses(const std::vector<NodeIndex>& nodes, const std::vector<double>& values);  // kg
void set_masses(Engine& engine, const std::vector<NodeIndex>& nodes, const std::vector<double>& values);

// Their springs, elements and faces are removed, and they are fixed.
void check_removal(const Engine& engine, const std::vector<NodeIndex>& nodes);
void remove_nodes(Engine& engine, const std::vector<NodeIndex>& nodes);

}  // namespace springnet
