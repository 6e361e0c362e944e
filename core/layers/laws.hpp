// Laws as the layers use them: components, and their parameters in columns.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "layers/elements/scalars.hpp"
#include "layers/input_sets.hpp"
#include "layers/internal.hpp"
#include "layers/prepared.hpp"
#include "layers/shared.hpp"
#include "layers/signals.hpp"

namespace springnet::layers {

inline constexpr std::size_t max_parameters = 32;  // of one law
inline constexpr std::size_t max_inputs = 8;

// A spring function or viscosity function, or none.
struct Law {
  std::shared_ptr<const Component> component;
  std::size_t parameter_count = 0;
  std::size_t first_column = 0;  // of its parameters in Group::columns
  std::size_t input_count = 0;
  std::size_t first_input_column = 0;  // of the numbers of its signals
  std::size_t state_count = 0;
  std::size_t first_state = 0;     // among those of its group
  std::uint32_t update_order = 1;  // the highest of its steps
  bool reads_start = false;        // its steps of order 1 do
  bool reads_rate = false;
  bool relative = false;        // reads the relative speed, acts along the relative velocity
  std::uint32_t invariant = 0;  // SPRINGNET_LENGTH …
  // Of a law over several scalars: where each of them is in the list of its group.
  std::uint32_t scalar_count = 0;
  std::array<std::uint8_t, max_scalars> scalar{};
  // [scalar of the law] whether it reads the present value, and answers a force; else the value at rest alone.
  std::array<bool, max_scalars> reads{};
  bool reads_direction = false;
  std::shared_ptr<const Prepared> prepared;     // null: the law prepares nothing
  std::vector<std::span<const double>> tables;  // of the network, that it is made of

  explicit operator bool() const noexcept { return component != nullptr; }
  [[nodiscard]] bool can(std::uint64_t capability) const noexcept {
    return component && (component->description->capabilities & capability) != 0;
  }
  // Whether its force derives from the energy that it returns. (With states that step along it does not.)
  [[nodiscard]] bool has_potential() const noexcept {
    return can(SPRINGNET_HAS_ENERGY) && !reads_rate && !relative && state_count == 0;
  }
};

// Springs and elements with the same two laws and prepared tables. columns[0] is the rest length or reference value,
// followed by the parameters of the spring function and of the viscosity function, then by the numbers of the signals
// that these read as inputs; each distinct combination is a row.
struct Group {
  Law spring;
  Law viscosity;
  SharedVector<Column<double>> columns;
  const Signals* signals = nullptr;  // null if the laws have no inputs
  ScalarList scalars{};              // of laws over several
  // Rows before any change while the network is simulated (layout_changes.cpp), and the columns in which they differ.
  // Rows that are added later may differ in every column.
  std::size_t first_rows = 0;
  std::vector<std::uint8_t> differs{};

  [[nodiscard]] std::size_t row_count() const noexcept { return columns[0].size(); }
  [[nodiscard]] bool is_same(std::size_t column) const noexcept { return columns[column].is_uniform(); }
  // The spring function, then the viscosity function.
  [[nodiscard]] std::array<const Law*, 2> laws() const noexcept { return {&spring, &viscosity}; }
  [[nodiscard]] std::size_t state_count() const noexcept { return spring.state_count + viscosity.state_count; }
  [[nodiscard]] bool can(std::uint64_t capability) const noexcept {
    return spring.can(capability) || viscosity.can(capability);
  }
  [[nodiscard]] bool reads_rate() const noexcept { return spring.reads_rate || viscosity.reads_rate; }
  [[nodiscard]] bool reads_direction() const noexcept { return spring.reads_direction || viscosity.reads_direction; }
};

// A neuron with its parameters; nodes refer to it by index.
struct NeuronKind {
  std::shared_ptr<const Component> component;
  std::vector<double> parameters;
};

// Rows of springs in their groups. They take no memory where all are the same, or spring s has row s, as in irregular
// meshes.
class RowNumbers {
 public:
  RowNumbers() = default;
  explicit RowNumbers(Column<std::uint32_t> rows) {
    own_ = true;
    for (std::size_t s = 0; s < rows.size() && own_; ++s) own_ = rows[s] == s;
    if (!own_) rows_ = std::move(rows);
  }
  [[nodiscard]] std::uint32_t operator[](std::size_t spring) const {
    return own_ ? static_cast<std::uint32_t>(spring) : rows_[spring];
  }
  // spring_count: of the network.
  void set(std::size_t spring, std::uint32_t row, std::size_t spring_count) {
    if (own_) {
      std::uint32_t* const rows = rows_.own().append_each(spring_count);
      for (std::size_t s = 0; s < spring_count; ++s) rows[s] = static_cast<std::uint32_t>(s);
      own_ = false;
    }
    rows_.own().set(spring, row);
  }

 private:
  SharedColumn<std::uint32_t> rows_;
  bool own_ = false;
};

// Signals are one simulation's own.
struct OwnSignals : std::unique_ptr<Signals> {
  using std::unique_ptr<Signals>::unique_ptr;
  using std::unique_ptr<Signals>::operator=;
  OwnSignals(OwnSignals&&) = default;
  OwnSignals& operator=(OwnSignals&&) = default;
  OwnSignals(const OwnSignals& other) : std::unique_ptr<Signals>(other ? std::make_unique<Signals>(*other) : nullptr) {}
  OwnSignals& operator=(const OwnSignals&) = delete;
};

// Copies share what is large until one changes its own; the signals that their groups read are those of the copied one,
// until share_signals().
//
// Groups and rows of all springs and elements of a network, and the neurons of its nodes. Throws Error if a component
// does not exist, a parameter is out of range, a law cannot prepare its tables or is used on an invariant that it does
// not read, or nobody reads a signal.
struct CompiledLaws {
  std::vector<Group> groups;
  SharedColumn<std::uint32_t> group;                       // [spring]
  RowNumbers row;                                          // [spring] row in its group
  SharedColumn<std::uint32_t> element_group, element_row;  // [element]
  std::vector<NeuronKind> neurons;                         // those that nodes have
  std::vector<std::uint32_t> neuron_number;                // [number in Network::neurons()] in `neurons`
  OwnSignals signals;                                      // numbered as Network::inputs(), then constants
  struct SignalInput {
    std::string name;
    std::vector<InputReader> readers;
  };
  std::vector<SignalInput> inputs;  // as Network::inputs()

  // To be called for a copy: its groups read its own signals.
  void share_signals() noexcept {
    for (Group& each : groups)
      if (each.signals != nullptr) each.signals = signals.get();
  }
  // Whether a law or neuron may be called from the thread alone that runs the simulation.
  [[nodiscard]] bool on_one_thread() const noexcept;
};
[[nodiscard]] CompiledLaws compile_laws(const Network& network, const PluginHost& plugins);

// SPRINGNET_FAILED with a message if a law or neuron has no derivatives.
[[nodiscard]] springnet_status require_derivatives(const Component& component, springnet_message& message);

// The smaller of two rupture margins; nan if either is.
[[nodiscard]] inline double lesser(double a, double b) noexcept { return a < b || std::isnan(a) ? a : b; }

}  // namespace springnet::layers
