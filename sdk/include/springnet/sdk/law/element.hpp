// What a law's formulas get: an element, and the table that the law made.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include <springnet/sdk/kernel.hpp>

namespace springnet::sdk {

// In place of a table, for laws without.
struct NoTable {};

// Laws without `static constexpr bool reads_rate = true` (or reads_time, reads_direction) are compiled once with
// elements whose rate (time, direction) has this type, which has no operations: a compiler error that mentions it means
// that the law reads e.rate (e.time, e.direction).
struct ReadsRateIsNotDeclared {};
struct ReadsTimeIsNotDeclared {};
struct ReadsDirectionIsNotDeclared {};
// Numbers of such elements: values, of types that no evaluation has.
inline constexpr std::size_t max_states = 8;
using Rateless = Dual<0, Dual<0>>;
using Timeless = Dual<0, Rateless>;
using Directionless = Dual<0, Timeless>;

// The inputs of a law for one element, besides its parameters. Table: what the law's prepare() returns.
template <class Real, class Table = NoTable>
struct Element {
  using Rate = std::conditional_t<std::is_same_v<Real, Rateless>, ReadsRateIsNotDeclared, Real>;
  using Time = std::conditional_t<std::is_same_v<Real, Timeless>, ReadsTimeIsNotDeclared, Real>;

  Real q;          // the invariant: length, m; or relative speed, m/s
  Rate rate;       // dq/dt, if the law declares reads_rate
  Real reference;  // rest length, m
  Time time;       // s, if the law declares reads_time
  const Table& table;
  const Real* states;
  const Real* inputs;

  [[nodiscard]] SPRINGNET_INLINE Real elongation() const { return q - reference; }            // m
  [[nodiscard]] SPRINGNET_INLINE Real strain() const { return (q - reference) / reference; }  // 1
  [[nodiscard]] SPRINGNET_INLINE const Real& state(std::size_t index) const { return states[index]; }
  [[nodiscard]] SPRINGNET_INLINE const Real& input(std::size_t index) const { return inputs[index]; }
};

// The same for a law over N invariants, in the order of its list `invariants`.
template <class Real, std::size_t N, class Table = NoTable>
struct SeveralOf {
  using Rate = typename Element<Real, Table>::Rate;
  using Time = typename Element<Real, Table>::Time;
  using Component = std::conditional_t<std::is_same_v<Real, Directionless>, ReadsDirectionIsNotDeclared, Real>;

  std::array<Real, N> q;          // the invariants: m, rad, m^2, m^3; unset where only the reference is read
  std::array<Rate, N> rate;       // their rates, if the law declares reads_rate
  std::array<Real, N> reference;  // their values at rest
  // Of the material at rest, if the law declares reads_direction: its components in the edges from node 0 to the
  // others, sum_k direction[k] (p_k+1 - p_0), of length 1.
  std::array<Component, 3> direction;
  Time time;  // s, if the law declares reads_time
  const Table& table;
  const Real* states;
  const Real* inputs;

  [[nodiscard]] SPRINGNET_INLINE const Real& state(std::size_t index) const { return states[index]; }
  [[nodiscard]] SPRINGNET_INLINE const Real& input(std::size_t index) const { return inputs[index]; }
};

// A step of the internal state, for a law's own update(). The element is that at the end of the step; its states are
// those at the start.
template <class Real>
struct Step {
  Real start_q, start_rate;  // the invariant and its rate at the start
  const Real* start_inputs;
  double duration;  // s
  int order;        // 1, or 2 if the law declares update_order = 2

  [[nodiscard]] SPRINGNET_INLINE const Real& start_input(std::size_t index) const { return start_inputs[index]; }
};

// The arrays that a law declared as `tables`, in that order, and the parameters of the material.
class TableSource {
 public:
  explicit TableSource(const springnet_preparation& preparation) : source_(&preparation) {}
  // Empty if the scene has none. Valid during prepare().
  [[nodiscard]] std::span<const double> operator[](std::size_t index) const {
    return {source_->tables[index], source_->tables[index] == nullptr ? 0 : source_->lengths[index]};
  }
  [[nodiscard]] double parameter(std::size_t index) const { return source_->parameters[index]; }

 private:
  const springnet_preparation* source_;
};

}  // namespace springnet::sdk
