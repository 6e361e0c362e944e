// Calls a law, over one invariant or several, for one element, with every first derivative.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <springnet/sdk/plugin.h>
#include <springnet/sdk/law/jacobian.hpp>

namespace springnet::test {

// All that a law reads, as one list of numbers in the order of the columns of its Jacobian; an update reads those of
// its start as well.
struct JacobianCall {
  const springnet_component* component;
  const springnet_law* law;
  sdk::JacobianLayout layout;
  bool several;
  double time_step = 0.0;  // above 0: a step of the states
  std::uint32_t order = 1;
  const void* table = nullptr;
  std::uint32_t instruction_set = SPRINGNET_GENERIC;

  explicit JacobianCall(const springnet_component& of)
      : component(&of),
        law(static_cast<const springnet_law*>(of.implementation)),
        layout{law->invariant == SPRINGNET_SEVERAL ? law->invariant_count : 1, of.parameter_count, law->state_count,
               law->input_count},
        several(law->invariant == SPRINGNET_SEVERAL) {}

  [[nodiscard]] bool can(std::uint64_t capability) const { return (component->capabilities & capability) != 0; }
  [[nodiscard]] bool reads_value(std::size_t i) const {
    return !several || (law->invariants[i]->flags & SPRINGNET_REFERENCE_ONLY) == 0;
  }
  // Whether a row exists and a column is read.
  [[nodiscard]] bool has_row(std::size_t row) const {
    if (row == layout.energy()) return can(SPRINGNET_HAS_ENERGY);
    if (row == layout.margin()) return can(SPRINGNET_HAS_RUPTURE);
    return true;
  }
  [[nodiscard]] std::size_t columns() const { return layout.columns(time_step > 0.0); }

  // Values of all rows, 0 where there is none; and, if wanted, the matrix.
  std::vector<double> operator()(const std::vector<double>& at, std::vector<double>* matrix = nullptr) const {
    const std::size_t V = layout.invariants, P = layout.parameters, S = layout.states, I = layout.inputs;
    const auto from = [&at](std::size_t column) { return &at[column]; };
    const auto list = [&](std::size_t first, std::size_t count) {
      std::vector<const double*> pointers;
      for (std::size_t i = 0; i < count; ++i) pointers.push_back(from(first + i));
      pointers.push_back(nullptr);  // data() of an empty list would be null
      return pointers;
    };
    std::vector<double> rows(layout.rows(), 0.0);
    springnet_message message{};
    springnet_law_batch batch{};
    batch.struct_size = sizeof batch;
    batch.count = 1;
    batch.instruction_set = instruction_set;
    batch.time = at[layout.time()];
    batch.table = table;
    batch.message = &message;
    const std::vector<std::uint32_t> strides(P + I + 1, 0);
    const auto values = list(layout.value(), V), rates = list(layout.rate(), V),
               references = list(layout.reference(), V), parameters = list(layout.parameter(0), P),
               states = list(layout.state(0), S), inputs = list(layout.input(0), I),
               direction = list(layout.direction(0), 3);
    batch.parameters = parameters.data();
    batch.parameter_strides = strides.data();
    batch.states = states.data();
    batch.inputs = inputs.data();
    batch.input_strides = strides.data();
    std::vector<double*> forces, state_rates;
    for (std::size_t i = 0; i < V; ++i) forces.push_back(&rows[layout.force(i)]);
    for (std::size_t i = 0; i < S; ++i) state_rates.push_back(&rows[layout.state_row(i)]);
    if (several) {
      batch.values = values.data();
      batch.rates = rates.data();
      batch.references = references.data();
      batch.direction = direction.data();
      batch.forces = forces.data();
    } else {
      batch.q = values[0];
      batch.rate = rates[0];
      batch.reference = references[0];
      batch.force = forces[0];
    }
    if (can(SPRINGNET_HAS_ENERGY)) batch.energy = &rows[layout.energy()];
    if (can(SPRINGNET_HAS_RUPTURE)) batch.margin = &rows[layout.margin()];
    std::vector<double*> derivatives;
    if (matrix != nullptr) {
      matrix->assign(layout.rows() * columns(), -12345.0);
      for (std::size_t row = 0; row < layout.rows(); ++row)
        for (std::size_t column = 0; column < columns(); ++column)
          derivatives.push_back(has_row(row) ? matrix->data() + row * columns() + column : nullptr);
      batch.derivatives = derivatives.data();
    }
    springnet_status status = SPRINGNET_OK;
    if (time_step > 0.0) {
      const auto start_values = list(layout.start_value(), V), start_rates = list(layout.start_rate(), V),
                 start_inputs = list(layout.start_input(0), I);
      springnet_law_update update{};
      update.struct_size = sizeof update;
      update.order = order;
      update.batch = &batch;
      update.time_step = time_step;
      update.start_q = start_values[0];
      update.start_rate = start_rates[0];
      update.start_inputs = start_inputs.data();
      update.start_values = start_values.data();
      update.start_rates = start_rates.data();
      update.next = state_rates.data();
      status = law->update(law->context, &update);
    } else {
      if (S > 0) batch.state_rates = state_rates.data();
      status = law->evaluate(law->context, &batch);
    }
    if (status != SPRINGNET_OK) throw std::runtime_error(message.text);
    return rows;
  }
};

}  // namespace springnet::test
