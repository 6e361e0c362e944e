// Where first derivatives are in springnet_law_batch::derivatives.
#pragma once

#include <cstddef>

namespace springnet::sdk {

// The matrix of a law over `invariants` scalars (1 for most), row by row.
struct JacobianLayout {
  std::size_t invariants, parameters, states, inputs;

  // Rows.
  [[nodiscard]] constexpr std::size_t force(std::size_t i = 0) const { return i; }
  [[nodiscard]] constexpr std::size_t energy() const { return invariants; }
  [[nodiscard]] constexpr std::size_t margin() const { return invariants + 1; }
  [[nodiscard]] constexpr std::size_t state_row(std::size_t i) const { return invariants + 2 + i; }  // rate, or next
  [[nodiscard]] constexpr std::size_t rows() const { return invariants + 2 + states; }
  // Columns.
  [[nodiscard]] constexpr std::size_t value(std::size_t i = 0) const { return i; }
  [[nodiscard]] constexpr std::size_t rate(std::size_t i = 0) const { return invariants + i; }
  [[nodiscard]] constexpr std::size_t reference(std::size_t i = 0) const { return 2 * invariants + i; }
  [[nodiscard]] constexpr std::size_t parameter(std::size_t i) const { return 3 * invariants + i; }
  [[nodiscard]] constexpr std::size_t state(std::size_t i) const { return parameter(parameters) + i; }
  [[nodiscard]] constexpr std::size_t input(std::size_t i) const { return state(states) + i; }
  [[nodiscard]] constexpr std::size_t time() const { return input(inputs); }
  [[nodiscard]] constexpr std::size_t direction(std::size_t i) const { return time() + 1 + i; }
  // In an update alone: of the step's start.
  [[nodiscard]] constexpr std::size_t start_value(std::size_t i = 0) const { return direction(3) + i; }
  [[nodiscard]] constexpr std::size_t start_rate(std::size_t i = 0) const { return start_value(invariants) + i; }
  [[nodiscard]] constexpr std::size_t start_input(std::size_t i) const { return start_rate(invariants) + i; }
  [[nodiscard]] constexpr std::size_t columns(bool of_update) const {
    return of_update ? start_input(inputs) : direction(3);
  }
};

}  // namespace springnet::sdk
