// The network as CVODE sees it: y = [px py pz vx vy vz z] (structure of arrays; 6 node_count numbers, then the internal
// state of laws), p' = v, v' = a, z' = r.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <springnet/sdk/host.hpp>

#include "sundials.hpp"

namespace springnet::cvode {

class Equations {
 public:
  explicit Equations(const sdk::Host& host) noexcept : host_(host) {}

  // Error weights are 1 / tolerance of a component: `position`, m, for positions, so that the result does not depend on
  // the origin; relative |v| + `velocity`, m/s, for velocities; relative (|z| + the scale that its law declares) for
  // internal states.
  struct Tolerances {
    double relative;
    double position;
    double velocity;
  };
  void set_tolerances(const Tolerances& tolerances) noexcept { tolerances_ = tolerances; }
  [[nodiscard]] const Tolerances& tolerances() const noexcept { return tolerances_; }

  // Functions for CVODE: 0: done, > 0: a smaller step may succeed, < 0: failed. failure() has the reason of the last
  // failure.
  int right_side(double time, N_Vector y, N_Vector rate) noexcept;
  int event_values(double time, N_Vector y, double* values) noexcept;  // needs event_directions() of the right size
  int error_weights(N_Vector y, N_Vector weights) const noexcept;
  // Derivatives of the accelerations at (time, y), for jacobian_times, diagonal_blocks, factorise and solve. Internal
  // states are eliminated from them, for I - gamma J: anew for each gamma, s.
  int linearise(double time, N_Vector y, double gamma) noexcept;
  // See springnet_internal_change; dp, dv, change, acceleration may be null.
  int change_internal(const double* right_side, const double* dp, const double* dv, double* change,
                      double* acceleration) noexcept;
  // out = da/dp dp + da/dv dv, 3 node_count numbers each.
  int jacobian_times(const double* dp, const double* dv, double* out) noexcept;
  // rate = df/dy change + df/d(values of the sets) along theirs, at (time, y), where the derivatives of the last
  // linearise() are. Without internal states.
  int change_rate(double time, N_Vector y, std::span<const springnet_parameter_set* const> sets, const double* change,
                  double* rate) noexcept;
  // Matrix I - gamma da/dv - gamma^2 da/dp.
  int factorise(double gamma) noexcept;
  int solve(const double* right_side, double* x) noexcept;
  int diagonal_blocks(double velocity_weight, double position_weight, double* out) noexcept;
  // Projects 3 node_count velocities onto rigid connections and surfaces; mobility: see plugin.h.
  int project(const double* mobility, double* values) noexcept;
  // correction = projection of y onto rigid connections and surfaces at `time`, less y.
  int correction(double time, N_Vector y, N_Vector correction) noexcept;

  // Net forces at a state of the host, N.
  void evaluate_force(double time, springnet_state& state);

  // One for each event of the network: the direction in which it crosses 0, -1 falling, +1 rising, from the last
  // evaluation.
  [[nodiscard]] std::vector<std::int32_t>& event_directions() noexcept { return event_directions_; }

  // Whether rigid connections or sliding contacts constrain the motion now.
  [[nodiscard]] bool bound() const;
  // Whether a node slides on a surface, or bodies touch.
  [[nodiscard]] bool slides() const;
  [[nodiscard]] bool touches_bodies() const noexcept;

  [[nodiscard]] const sdk::Host& host() const noexcept { return host_; }
  [[nodiscard]] std::size_t node_count() const noexcept { return host_.network().node_count; }
  [[nodiscard]] std::size_t internal_count() const noexcept { return host_.network().internal_count; }
  [[nodiscard]] std::size_t size() const noexcept { return 6 * node_count() + internal_count(); }
  [[nodiscard]] const std::optional<sdk::Failure>& failure() const noexcept { return failure_; }
  void clear_failure() noexcept { failure_.reset(); }

  struct Work {
    std::uint64_t evaluations = 0;  // of all springs
    std::uint64_t linearisations = 0;
    std::uint64_t jacobian_products = 0;
    std::uint64_t parameter_products = 0;
    std::uint64_t event_evaluations = 0;
    std::uint64_t projections = 0;
  };
  [[nodiscard]] const Work& work() const noexcept { return work_; }

 private:
  [[nodiscard]] springnet_evaluation at(double time, N_Vector y);
  // The internal state of y within the bounds that laws declare. Throws a recoverable Failure where y lies outside by
  // more than its error.
  [[nodiscard]] const double* within_bounds(const double* internal);
  // Whether a correction is as small as the error of a step explains.
  [[nodiscard]] bool is_small(N_Vector y, N_Vector correction) const noexcept;
  template <class Body>
  int guarded(const Body& body) noexcept;

  sdk::Host host_;
  Tolerances tolerances_{};
  springnet_internal internal_{};  // of the last at()
  std::vector<double> bounded_;    // [internal_count]
  std::vector<double> by_state_;   // [3 node], of change_rate()
  std::vector<std::int32_t> event_directions_;
  std::optional<sdk::Failure> failure_;
  Work work_;
};

}  // namespace springnet::cvode
