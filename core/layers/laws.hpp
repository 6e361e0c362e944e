// Laws as the layers use them: a component, its parameters in columns, and how it is called on a batch.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet::layers {

inline constexpr std::size_t max_parameters = 32;  // of one law

// A spring function or viscosity function; null component: none.
struct Law {
  std::shared_ptr<const Component> component;
  std::size_t parameter_count = 0;
  std::size_t first_column = 0;  // of its parameters in Group::columns
  bool reads_rate = false;
  bool relative = false;        // reads the relative speed, acts along the relative velocity
  std::uint32_t invariant = 0;  // SPRINGNET_LENGTH …

  explicit operator bool() const noexcept { return component != nullptr; }
  [[nodiscard]] bool can(std::uint32_t capability) const noexcept {
    return component && (component->description->capabilities & capability) != 0;
  }
};

// Springs and elements of the same laws. columns[0] is the rest length or reference, then come the parameters of the
// spring function and of the viscosity function; a row is a distinct combination of them.
struct Group {
  Law spring;
  Law viscosity;
  std::vector<std::vector<double>> columns;

  [[nodiscard]] std::size_t row_count() const noexcept { return columns[0].size(); }
};

// Nodes of the same neuron and parameters.
struct NeuronKind {
  std::shared_ptr<const Component> component;
  std::vector<double> parameters;
};

// Groups and rows of all springs and elements of a network, neurons of all nodes. Throws Error if a component is not
// there, a parameter is out of range, a law needs what this engine does not evaluate, or is used on what it does not
// read.
struct CompiledLaws {
  std::vector<Group> groups;
  std::vector<std::uint32_t> group;                       // [spring]
  std::vector<std::uint32_t> row;                         // [spring] row in its group
  std::vector<std::uint32_t> element_group, element_row;  // [element]
  std::vector<NeuronKind> neurons;                        // as Network::neurons()
};
[[nodiscard]] CompiledLaws compile_laws(const Network& network, const PluginHost& plugins);

// Rows of the elements of a batch: one for all, or one an element.
struct RowSelection {
  const std::uint32_t* rows = nullptr;  // null: `row` for all
  std::uint32_t row = 0;
};

// What a batch of a law writes; null where it is not wanted.
struct LawOutputs {
  double* force = nullptr;
  double* energy = nullptr;
  double* force_by_q = nullptr;
  double* force_by_rate = nullptr;
  double* margin = nullptr;
};

// Calls a law on `count` elements. At most max_segment elements. Does not throw; on failure `message` names the law,
// its plugin and the reason.
[[nodiscard]] springnet_status call_law(const Group& group, const Law& law, std::uint32_t instruction_set, double time,
                                        std::size_t count, const RowSelection& rows, const double* q,
                                        const double* rate, const LawOutputs& out, springnet_message* message);

// SPRINGNET_FAILED with a message unless a law or neuron offers derivatives.
[[nodiscard]] springnet_status require_derivatives(const Component& component, springnet_message& message);

// The smaller of two margins; nan, which tells nothing, if one of them is.
[[nodiscard]] inline double lesser(double a, double b) noexcept { return a < b || std::isnan(a) ? a : b; }

}  // namespace springnet::layers
