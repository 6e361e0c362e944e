#include "equations.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace springnet::cvode {

// No exception may pass through SUNDIALS, which is C.
template <class Body>
int Equations::guarded(const Body& body) noexcept {
  try {
    body();
    return 0;
  } catch (const sdk::Failure& failure) {
    failure_ = failure;
    return failure.recoverable() ? 1 : -1;
  } catch (...) {
    failure_.reset();
    return -1;
  }
}

const double* Equations::within_bounds(const double* internal) {
  constexpr double slack = 10.0;  // tolerances
  const springnet_network& network = host_.network();
  bounded_.assign(internal, internal + network.internal_count);
  for (std::uint64_t r = 0; r < network.internal_range_count; ++r) {
    const springnet_internal_range& range = *network.internal_ranges[r];
    const double allowed = slack * tolerances_.relative * range.state->scale;
    for (std::uint64_t i = range.first; i < range.first + range.count; ++i) {
      const double inside = std::clamp(bounded_[i], range.state->smallest, range.state->largest);
      if (!(std::abs(bounded_[i] - inside) <= allowed + slack * tolerances_.relative * std::abs(inside)))
        throw sdk::Failure(
            std::string("the internal state '") + range.state->name + "' of '" + range.law + "' left its bounds",
            SPRINGNET_RECOVERABLE);
      bounded_[i] = inside;
    }
  }
  return bounded_.data();
}

springnet_evaluation Equations::at(double time, N_Vector y) {
  const std::size_t n = node_count();
  const double* values = data(y);
  auto evaluation = sdk::sized<springnet_evaluation>();
  evaluation.time = time;
  evaluation.position = {values, values + n, values + 2 * n};
  evaluation.velocity = {values + 3 * n, values + 4 * n, values + 5 * n};
  if (internal_count() == 0) return evaluation;
  internal_ = sdk::sized<springnet_internal>();
  internal_.values = within_bounds(values + 6 * n);
  evaluation.internal = &internal_;
  return evaluation;
}

int Equations::right_side(double time, N_Vector y, N_Vector rate) noexcept {
  return guarded([&] {
    const std::size_t n = node_count();
    double* out = data(rate);
    // p' = v
    std::copy_n(data(y) + 3 * n, 3 * n, out);
    // v' = a(F(p, v, t), p, v, t)
    springnet_evaluation evaluation = at(time, y);
    evaluation.acceleration = {out + 3 * n, out + 4 * n, out + 5 * n};
    // z' = r(q, q', z), 0 for elements that were removed
    std::fill_n(out + 6 * n, internal_count(), 0.0);
    internal_.rates = out + 6 * n;
    ++work_.evaluations;
    host_.evaluate(evaluation);
  });
}

int Equations::event_values(double time, N_Vector y, double* values) noexcept {
  return guarded([&] {
    ++work_.event_evaluations;
    host_.event_values(at(time, y), values, event_directions_.data());
  });
}

int Equations::error_weights(N_Vector y, N_Vector weights) const noexcept {
  const std::size_t n = node_count();
  const double* v = data(y) + 3 * n;
  double* w = data(weights);
  std::fill_n(w, 3 * n, 1.0 / tolerances_.position);
  for (std::size_t i = 0; i < 3 * n; ++i) {
    w[3 * n + i] = 1.0 / (tolerances_.relative * std::abs(v[i]) + tolerances_.velocity);
  }
  const springnet_network& network = host_.network();
  const double* z = data(y) + 6 * n;
  for (std::uint64_t r = 0; r < network.internal_range_count; ++r) {
    const springnet_internal_range& range = *network.internal_ranges[r];
    for (std::uint64_t i = range.first; i < range.first + range.count; ++i)
      w[6 * n + i] = 1.0 / (tolerances_.relative * (std::abs(z[i]) + range.state->scale));
  }
  return 0;
}

int Equations::linearise(double time, N_Vector y, double gamma) noexcept {
  return guarded([&] {
    ++work_.linearisations;
    host_.linearise(at(time, y), internal_count() > 0 ? gamma : 0.0);
  });
}

int Equations::change_internal(const double* right_side, const double* dp, const double* dv, double* change,
                               double* acceleration) noexcept {
  return guarded([&] { host_.change_internal(right_side, dp, dv, change, acceleration); });
}

int Equations::jacobian_times(const double* dp, const double* dv, double* out) noexcept {
  return guarded([&] {
    ++work_.jacobian_products;
    host_.jacobian_times(dp, dv, out);
  });
}

int Equations::change_rate(double time, N_Vector y, std::span<const springnet_parameter_set* const> sets,
                           const double* change, double* rate) noexcept {
  return guarded([&] {
    const std::size_t n = node_count();
    const double* const velocity = change + 3 * n;
    double* const acceleration = rate + 3 * n;
    std::copy_n(velocity, 3 * n, rate);
    std::fill_n(acceleration, 3 * n, 0.0);
    if (!sets.empty()) {
      const springnet_evaluation evaluation = at(time, y);
      ++work_.parameter_products;
      host_.parameter_tangent(evaluation, sets, {nullptr, acceleration, nullptr});
    }
    by_state_.resize(3 * n);
    ++work_.jacobian_products;
    host_.jacobian_times(change, velocity, by_state_.data());
    for (std::size_t i = 0; i < 3 * n; ++i) acceleration[i] += by_state_[i];
    const springnet_network& network = host_.network();
    for (std::size_t k = 0; k < n; ++k)  // their motion is given
      if (network.fixed[k] != 0 || network.held[k] != 0)
        for (std::size_t i = k; i < 6 * n; i += n) rate[i] = 0.0;
  });
}

int Equations::factorise(double gamma) noexcept {
  return guarded([&] { host_.factorise(gamma, gamma * gamma); });
}

int Equations::solve(const double* right_side, double* x) noexcept {
  return guarded([&] { host_.solve(right_side, x); });
}

int Equations::diagonal_blocks(double velocity_weight, double position_weight, double* out) noexcept {
  return guarded([&] { host_.diagonal_blocks(velocity_weight, position_weight, out); });
}

int Equations::project(const double* mobility, double* values) noexcept {
  return guarded([&] { host_.project(mobility, values); });
}

int Equations::correction(double time, N_Vector y, N_Vector correction) noexcept {
  const int status = guarded([&] {
    const std::size_t n = node_count();
    const double* before = data(y);
    double* after = data(correction);
    std::copy_n(before, 6 * n, after);
    ++work_.projections;
    host_.project_state(time, {after, after + n, after + 2 * n}, {after + 3 * n, after + 4 * n, after + 5 * n});
    for (std::size_t i = 0; i < 6 * n; ++i) after[i] -= before[i];
    std::fill_n(after + 6 * n, internal_count(), 0.0);
  });
  return status != 0 || is_small(y, correction) ? status : 1;
}

// A step satisfies the constraints up to its error. A large correction means that the step left a smooth part of a
// surface, for example past the edge of a box's face. Its path is then unknown, since the error test sees only its end.
bool Equations::is_small(N_Vector y, N_Vector correction) const noexcept {
  constexpr double max_correction = 100.0;  // tolerances
  const std::size_t n = node_count();
  const double *v = data(y) + 3 * n, *change = data(correction);
  double sum = 0.0;
  for (std::size_t i = 0; i < 3 * n; ++i) {
    const double position = change[i] / tolerances_.position;
    const double velocity = change[3 * n + i] / (tolerances_.relative * std::abs(v[i]) + tolerances_.velocity);
    sum += position * position + velocity * velocity;
  }
  return sum <= max_correction * max_correction * 6.0 * static_cast<double>(n);
}

bool Equations::bound() const {
  const springnet_network& network = host_.network();
  return network.rigid_count > 0 || slides();
}

bool Equations::slides() const {
  const springnet_network& network = host_.network();
  for (std::size_t k = 0; network.surface_count > 0 && k < network.node_count; ++k)
    if (network.touching[k] != 0 && network.held[k] == 0) return true;
  return touches_bodies();
}

bool Equations::touches_bodies() const noexcept {
  const springnet_network& network = host_.network();
  return network.body_contact_count > 0 && *network.pushed_count > 0;
}

void Equations::evaluate_force(double time, springnet_state& state) {
  springnet_evaluation evaluation = sdk::evaluation_at(time, state);
  evaluation.force = state.force;
  auto internal = sdk::sized<springnet_internal>();
  internal.values = state.internal;
  if (internal_count() > 0) evaluation.internal = &internal;
  ++work_.evaluations;
  host_.evaluate(evaluation);
}

}  // namespace springnet::cvode
