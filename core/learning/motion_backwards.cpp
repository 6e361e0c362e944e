#include "learning/motion.hpp"

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// What the step after a state has for the accelerations at its start; dp and dv are derivatives by this state. at: of
// the step that ends at `until`, s, and that begins where the part of this number ends.
void MotionDerivatives::Impl::start_backwards(const State& at, std::size_t number, double until) {
  const springnet_evaluation start = evaluation(at);
  const sdk::Host& of = host_at_start(number, at.time, until);
  of.linearise(start);
  if (internal.any()) {
    work = pending;
    if (&of != &host) {
      host.linearise(start);
      constraints->project(true, work.data());
    }
    internal.weigh_accelerations(start, work);
  }
  of.jacobian_transposed_times(pending.data(), product.data(), other.data(), SPRINGNET_TRUE_FRICTION);
  if (&of != &host) constraints->add_carried_transposed(pending, product);
  dp += product;
  dv += other;
  learned.add_cotangent(engine_of(of), of, start, pending.data());
  pending.resize(0);
}

// Those of the next step may have other states, springs, contacts or loads than those at the end of this one.
void MotionDerivatives::Impl::begin_backwards(const Step& own) {
  // What the solver leaves of a system is divided by w: a short part must not carry the weights of a long step.
  const bool is_short = own.until.time - own.from.time < 0.5 * time_step;
  if (pending.size() > 0 && (is_short || !same_at_both || removals.any_at(own.number) ||
                             scene_changes.any_at(own.number) || is_constrained_at(own.number)))
    start_backwards(own.until, own.number, pending_until);
  set_for_step(own.number);
  begin_step(own);
  if (pending.size() > 0 && engine.model().load_revision != pending_loads) {
    start_backwards(own.until, own.number, pending_until);
    begin_step(own);
  }
}

// With J the derivatives of the accelerations at the end of a step, x the solution of its transposed system and
// `pending` what the next step has for the same accelerations, their weights are m = w x + pending. With F the
// transpose of how outputs follow the velocities without constraints,
//   x = F(dp, dv) + F(J^T m),   m - w F(J^T m) = w F(dp, dv) + pending.
void MotionDerivatives::Impl::step_backwards(const Step& own) {
  begin_backwards(own);
  find_arrivals(own);
  land_transposed(dp, dv);
  const springnet_evaluation start = nodes_at(own.from), end = end_of(own);
  find_outputs(own);
  ByTime by_start;
  if (own.starts_at_event) by_start = find_times(own).start;
  solver.prepare(end, own.w, 1, &outputs);
  internal.weigh_end(end, dp, dv);
  clear_pinned(dp);
  clear_pinned(dv);
  outputs.to_free(dp, dv, rhs);
  rhs *= own.w;
  if (pending.size() > 0) rhs += pending;
  clear_pinned(rhs);
  weights_guess.find(rhs, weights);
  solver.solve_transposed(rhs, accuracy, weights, product, other);
  weights_guess.take(weights);
  learned.add_cotangent(engine, host, end, weights.data(), internal.weights());
  product += dp;
  other += dv;
  if (outputs.any()) {
    learned.add_to_masses(outputs.to_masses(product, other));
    if (learned.has_friction()) learned.add_to_friction(outputs.to_friction(product, other, learned.surface_count()));
  }
  outputs.to_free(product, other, solution);
  clear_pinned(solution);
  by_event_time = own.starts_at_event ? by_start.free.dot(solution) + by_start.p.dot(product) + by_start.v.dot(other) +
                                            by_start.z.dot(internal.all_weights())
                                      : 0.0;
  outputs.to_start(product, other, dp, dv);
  dv += solution;
  clear_pinned(dp);
  clear_pinned(dv);
  // Where nodes that are moved start matters if the time of the start does.
  internal.weigh_start(start, end, weights, dp, dv);
  pending.resize(0);
  if (own.c > 0.0) {
    pending = own.c * solution;
    pending_until = own.until.time;
    pending_loads = engine.model().load_revision;
  }
  // An event is between this start and the end before it.
  if (own.starts_at_event && pending.size() > 0) start_backwards(own.from, own.number - 1, pending_until);
}

VectorXd MotionDerivatives::Impl::adjoint(const std::function<void(std::size_t, StateChange&)>& add) {
  learned.begin_cotangent();
  weights_guess.clear();
  solver.begin();
  dp.setZero();
  dv.setZero();
  internal.begin_weights();
  pending.resize(0);
  by_event_time = 0.0;
  const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(nodes));
  for (std::size_t k = trajectory.size(); k-- > 0;) {
    StateChange own{zero, zero};
    add(k, own);
    if (own.positions.cols() != zero.cols() || own.velocities.cols() != zero.cols())
      throw Error(ErrorKind::input,
                  fmt::format("learning: derivatives by state {} are of {} and {} nodes, must be of {}", k,
                              own.positions.cols(), own.velocities.cols(), zero.cols()));
    add_from_user_order(own.positions, dp);
    add_from_user_order(own.velocities, dv);
    if (k > 0)
      with_messages([&] {
        const Parts parts = parts_of(k);
        for (auto each = parts.steps.rbegin(); each != parts.steps.rend(); ++each) part_backwards(*each);
      });
  }
  if (pending.size() > 0) {
    set_for_step(1);
    with_messages([&] { start_backwards(trajectory.at(0), 0, pending_until); });
  }
  clear_pinned(dv);
  return learned.cotangent(dv);
}

}  // namespace springnet
