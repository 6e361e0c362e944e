// Laws with internal state: as it is, with the rates, or stepped along.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <springnet/sdk/message.hpp>

#include "layers/law_pair.hpp"

namespace springnet::layers {
namespace {

constexpr std::size_t most_members = states_batch;

// A value for each member and state, or pair of states. Not initialised: written before it is read.
template <std::size_t rows>
struct Lists {
  alignas(64) double values[rows][most_members];
  double* pointers[rows];

  double** first(std::size_t count) noexcept {
    for (std::size_t j = 0; j < count; ++j) pointers[j] = values[j];
    return pointers;
  }
};

// Reads from, or writes to, an array over the internal state.
class StateAccess {
 public:
  StateAccess(const InternalSelection& internal, const Law& law, std::size_t begin, std::size_t size) noexcept
      : place_(internal.place + begin),
        first_(internal.group->first + law.first_state * internal.group->count),
        pitch_(internal.group->count),
        size_(size) {}

  [[nodiscard]] bool is_silent(std::size_t i) const noexcept { return (place_[i] & InternalLayout::silent) != 0; }
  [[nodiscard]] std::uint64_t index(std::size_t i, std::size_t state) const noexcept {
    return first_ + state * pitch_ + (place_[i] & ~InternalLayout::silent);
  }
  void gather(const double* from, std::size_t state, double* to) const noexcept {
    const double* const values = from + first_ + state * pitch_;
    for (std::size_t i = 0; i < size_; ++i) to[i] = values[place_[i] & ~InternalLayout::silent];
  }
  void scatter(const double* from, std::size_t state, double* to) const noexcept {
    double* const values = to + first_ + state * pitch_;
    for (std::size_t i = 0; i < size_; ++i)
      if ((place_[i] & InternalLayout::silent) == 0) values[place_[i]] = from[i];
  }

 private:
  const std::uint32_t* place_;
  std::uint64_t first_, pitch_;
  std::size_t size_;
};

// Whether states that a law gives are finite and, but for rounding, within the bounds that it declares; else the
// message says which is not.
bool are_within_bounds(const Law& law, const StateAccess& access, const double (*states)[most_members],
                       const char* when, const springnet_law_batch& call) {
  constexpr double rounding = 1e-9, largest = std::numeric_limits<double>::max();
  for (std::size_t j = 0; j < law.state_count; ++j) {
    const springnet_parameter& state = *law.component->law().states[j];
    const double slack = rounding * state.scale;
    const double from = std::max(state.smallest - slack - rounding * std::abs(state.smallest), -largest);
    const double to = std::min(state.largest + slack + rounding * std::abs(state.largest), largest);
    const auto is_outside = [&](std::size_t i) { return !((states[j][i] >= from) & (states[j][i] <= to)); };
    unsigned outside = 0;  // nearly always none: a loop that vectorises
    for (std::size_t i = 0; i < call.count; ++i) outside |= static_cast<unsigned>(is_outside(i));
    for (std::size_t i = 0; outside != 0 && i < call.count; ++i) {
      if (!is_outside(i) || access.is_silent(i)) continue;
      sdk::detail::write_message(
          call.message,
          fmt::format("its internal state '{}' {} {}, out of its bounds", state.name, when, states[j][i]).c_str());
      return false;
    }
  }
  return true;
}

springnet_status step(const InternalView& view, const Law& law, const StateAccess& access,
                      const double* const* start_inputs, springnet_law_batch& call) {
  const springnet_law& functions = law.component->law();
  alignas(64) double start_q[most_members], start_rate[most_members];
  Lists<max_states> next;
  springnet_law_update update{};
  update.struct_size = sizeof update;
  update.order = std::min(view.order, law.update_order);
  update.batch = &call;
  update.time_step = view.time_step;
  update.start_inputs = start_inputs;
  if (view.start_q != nullptr) {
    access.gather(view.start_q, 0, start_q);
    update.start_q = start_q;
    if (law.reads_rate) {
      access.gather(view.start_rate, 0, start_rate);
      update.start_rate = start_rate;
    }
  }
  if (view.next != nullptr) update.next = next.first(law.state_count);
  const springnet_status status = functions.update(functions.context, &update);
  if (status != SPRINGNET_OK || view.next == nullptr) return status;
  if (!are_within_bounds(law, access, next.values, "becomes", call)) return SPRINGNET_RECOVERABLE;
  for (std::size_t j = 0; j < law.state_count; ++j) access.scatter(next.values[j], j, view.next);
  return status;
}

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_states, max_states>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_states, 1>;

// With states that follow, dQ = Q_q dq + Q_z dz and dz = (I - w r_z)^-1 w (r_q dq + r_u du).
springnet_status eliminate(const InternalView& view, const Law& law, const StateAccess& access,
                           springnet_law_batch& call) {
  const springnet_law& functions = law.component->law();
  const std::size_t S = law.state_count;
  const auto size = static_cast<Eigen::Index>(S);
  Lists<max_states> by_states, by_q, by_rate;
  Lists<max_states * max_states> rates;
  call.force_by_states = by_states.first(S);
  call.rates_by_q = by_q.first(S);
  call.rates_by_rate = by_rate.first(S);
  call.rates_by_states = rates.first(S * S);
  const springnet_status status = functions.evaluate(functions.context, &call);
  if (status != SPRINGNET_OK) return status;
  for (std::size_t i = 0; i < call.count; ++i) {
    Matrix A(size, size);
    Vector by_state(size);
    for (std::size_t j = 0; j < S; ++j) {
      by_state[static_cast<Eigen::Index>(j)] = by_states.values[j][i];
      for (std::size_t k = 0; k < S; ++k)
        A(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(k)) =
            (j == k ? 1.0 : 0.0) - view.elimination * rates.values[j * S + k][i];
    }
    const Matrix inverse = Eigen::PartialPivLU<Matrix>(A).inverse();
    const Vector y = view.elimination * inverse.transpose() * by_state;
    for (std::size_t j = 0; j < S; ++j) {
      const auto row = static_cast<Eigen::Index>(j);
      if (call.force_by_q != nullptr) call.force_by_q[i] += y[row] * by_q.values[j][i];
      if (call.force_by_rate != nullptr) call.force_by_rate[i] += y[row] * by_rate.values[j][i];
      if (view.record == nullptr || access.is_silent(i)) continue;
      double* const out = view.record->inverse.data() + max_states * access.index(i, j);
      for (std::size_t k = 0; k < S; ++k) out[k] = inverse(row, static_cast<Eigen::Index>(k));
    }
  }
  for (std::size_t j = 0; view.record != nullptr && j < S; ++j) {
    access.scatter(by_states.values[j], j, view.record->force_by_state.data());
    access.scatter(by_q.values[j], j, view.record->rate_by_q.data());
    access.scatter(by_rate.values[j], j, view.record->rate_by_rate.data());
  }
  return status;
}

// The states with which a law begins; `call` has those that it declares.
springnet_status begin_states(const Law& law, const StateAccess& access, springnet_law_batch& call, double* out) {
  const springnet_law& functions = law.component->law();
  Lists<max_states> states;
  springnet_law_start start{};
  start.struct_size = sizeof start;
  start.batch = &call;
  start.states = states.first(law.state_count);
  for (std::size_t j = 0; j < law.state_count; ++j) std::copy_n(call.states[j], call.count, states.values[j]);
  call.force = nullptr;
  const springnet_status status =
      functions.start == nullptr ? springnet_status{SPRINGNET_OK} : functions.start(functions.context, &start);
  if (status != SPRINGNET_OK) return status;
  if (!are_within_bounds(law, access, states.values, "starts at", call)) return SPRINGNET_FAILED;
  for (std::size_t j = 0; j < law.state_count; ++j) access.scatter(states.values[j], j, out);
  return status;
}

}  // namespace

springnet_status evaluate_with_states(const InternalSelection& internal, const Law& law, std::size_t begin,
                                      const double* const* start_inputs, springnet_law_batch& call) {
  const springnet_law& functions = law.component->law();
  const InternalView* const view = internal.group == nullptr ? nullptr : internal.view;
  Lists<max_states> states;
  call.states = states.first(law.state_count);
  if (view == nullptr || view->start != nullptr) {
    for (std::size_t j = 0; j < law.state_count; ++j)
      std::fill_n(states.values[j], call.count, functions.states[j]->default_value);
    if (view == nullptr) return functions.evaluate(functions.context, &call);
  }
  const StateAccess access(internal, law, begin, call.count);
  if (view->start != nullptr) return begin_states(law, access, call, view->start);
  for (std::size_t j = 0; j < law.state_count; ++j) access.gather(view->values, j, states.values[j]);
  if (view->time_step > 0.0) return step(*view, law, access, start_inputs, call);
  if (view->elimination > 0.0 && call.force_by_q != nullptr) return eliminate(*view, law, access, call);
  if (view->rates == nullptr) return functions.evaluate(functions.context, &call);
  Lists<max_states> rates;
  Lists<max_states> by_states;
  const bool energies =
      view->energy_by_states != nullptr && law.can(SPRINGNET_HAS_ENERGY) && law.can(SPRINGNET_HAS_DERIVATIVES);
  call.state_rates = rates.first(law.state_count);
  if (energies) call.energy_by_states = by_states.first(law.state_count);
  const springnet_status status = functions.evaluate(functions.context, &call);
  for (std::size_t j = 0; status == SPRINGNET_OK && j < law.state_count; ++j) {
    access.scatter(rates.values[j], j, view->rates);
    if (energies) access.scatter(by_states.values[j], j, view->energy_by_states);
  }
  return status;
}

}  // namespace springnet::layers
