#include "learning/motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/node_vectors.hpp"

namespace springnet {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void MotionDerivatives::Impl::record(State& to) const {
  to.time = simulation.time();
  to.p.resize(size());
  to.v.resize(size());
  const auto n = static_cast<Eigen::Index>(nodes);
  const ConstNodeMap p = simulation.positions(), v = simulation.velocities();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    to.p.segment(axis * n, n) = p.row(axis).transpose();
    to.v.segment(axis * n, n) = v.row(axis).transpose();
  }
  internal.record(simulation, to.z);
}

// What the derivative of a fixed point does not describe.
void MotionDerivatives::Impl::check_step(std::size_t state) {
  const auto refuse = [this](const std::string& what) {
    throw Error(ErrorKind::simulation,
                fmt::format("learning: {} at {:g} s is not differentiated", what, simulation.time()));
  };
  const StepReport& report = simulation.last_report();
  if (report.outcome != Outcome::settled) refuse("a step that has not settled");
  if (report.substeps > 0) refuse("a step that was divided as it did not settle");
  if (locates) {
    // Where the last part ended at an event, an instant is left until the step ends.
    if (!recorder.parts().empty() && !recorder.parts().back().events.empty()) ++part_count;
  } else {
    if (removals.take(simulation.events(), state, simulation.time()) != nullptr) refuse("a node that is jammed");
    scene_changes.take(state, simulation.time());
    if (constraints) constraints->history().record(simulation, state);
  }
  add_settled(report.residual);
  const std::vector<Event>& all = simulation.events();
  events.insert(events.end(), all.begin() + static_cast<std::ptrdiff_t>(events_before + events.size()), all.end());
}

void MotionDerivatives::Impl::add_settled(double residual) {
  const springnet_network& network = host.network();
  double lightest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < nodes; ++k)
    if (network.fixed[k] == 0) lightest = std::min(lightest, network.mass[k]);
  Settled next = settled.back();
  if (std::isfinite(residual)) next.velocity += time_step * residual / lightest;
  next.position += time_step * next.velocity;
  settled.push_back(next);
}

void MotionDerivatives::Impl::begin(const VectorXd& values) {
  settled.assign(1, {});
  simulation.restore(saved_start);
  begin_parts();
  removals.begin(simulation.events().size());
  scene_changes.begin();
  events.clear();
  events_before = simulation.events().size();
  learned.set(simulation, values);
  if (constraints) constraints->history().begin(simulation);
}

void MotionDerivatives::Impl::run(const VectorXd& values) {
  learned.check(values);
  begin(values);
  const State start = present();
  trajectory.run(steps, [this](std::size_t state) { check_step(state); });
  set_engines(values);
  check_start(start);
}

// Accelerations at the start are read by steps of second order alone, and depend on what is learned by velocities.
void MotionDerivatives::Impl::check_start(const State& start) {
  if (theta == 1.0) return;
  std::vector<std::uint32_t> moving = learned.with_start_velocities();
  for (std::uint32_t& node : moving) node = engine.model().layout.ordering().engine[node];
  const std::size_t n = nodes;
  const double *const p = start.p.data(), *const v = start.v.data();
  if (!moving.empty())
    learning::check_straight_angles(engine, start.time, {p, p + n, p + 2 * n, v, v + n, v + 2 * n}, moving);
}

// The engines as they are in the step that ends at a state; 0: at the start.
void MotionDerivatives::Impl::set_for_step(std::size_t until) {
  removals.set_for_step(until);
  scene_changes.set_for_step(until);
}

void MotionDerivatives::Impl::set_engines(const VectorXd& values) {
  learned.set(engine, values);
  if (constraints) learned.set(constraints->engine(), values);
}

void MotionDerivatives::Impl::begin_step(const Step& step) {
  internal.start_at(nodes_at(step.from), step.from.z);
  host.begin_step(step.from.time, step.until.time);
  learning::find_pinned(host.network(), pinned);
}

// For accelerations at the start of a step, at this state.
const sdk::Host& MotionDerivatives::Impl::host_at_start(std::size_t state, double from, double until) {
  if (is_constrained_at(state)) return constraints->begin_step(state, from, until);
  host.begin_step(from, until);
  return host;
}

void MotionDerivatives::Impl::find_arrivals(const Step& step) {
  arrivals.clear();
  if (!constraints || !constraints->any_within(step.number)) return;
  arrivals = constraints->arrivals({step.number, step.from.time, step.until.time, theta, step.from.p, step.from.v,
                                    step.until.p, step.until.v, step.kept});
  if (arrivals.empty()) return;
  end_velocity = step.until.v;
  for (const learning::Arrival& each : arrivals)
    learning::add_to_node(end_velocity, each.node, each.velocity - learning::node_of(end_velocity, each.node));
}

void MotionDerivatives::Impl::land(VectorXd& of_positions, VectorXd& of_velocities) const {
  for (const learning::Arrival& each : arrivals) {
    const Vector3 before = learning::node_of(of_velocities, each.node);
    const Vector3 after = each.by_velocity * before + each.by_position * learning::node_of(of_positions, each.node);
    learning::add_to_node(of_velocities, each.node, after - before);
  }
}

void MotionDerivatives::Impl::land_transposed(VectorXd& of_positions, VectorXd& of_velocities) const {
  for (const learning::Arrival& each : arrivals) {
    const Vector3 before = learning::node_of(of_velocities, each.node);
    learning::add_to_node(of_positions, each.node, each.by_position.transpose() * before);
    learning::add_to_node(of_velocities, each.node, each.by_velocity.transpose() * before - before);
  }
}

// Where `host` has begun the step: what constraints make of it.
void MotionDerivatives::Impl::find_outputs(const Step& step) {
  outputs.begin(nodes, step.c, step.w);
  if (!constraints || !constraints->any_within(step.number)) return;
  VectorXd free = step.from.v + step.w * accelerations(host, end_of(step));
  if (step.c > 0.0) {
    const sdk::Host& of = host_at_start(step.number - 1, step.from.time, step.until.time);
    free += step.c * accelerations(of, evaluation(step.from));
    begin_step(step);
  }
  constraints->find_outputs(
      {step.number, step.from.time, step.until.time, theta, step.from.p, step.from.v, step.until.p,
       arrivals.empty() ? step.until.v : end_velocity, step.kept, unsettled_until(step.until.time), &learned, locates},
      free, outputs);
}

// m/s. The residual is of the last sweep, which has moved nodes in contact by forces of the one before.
double MotionDerivatives::Impl::unsettled_until(double time) const {
  constexpr double residuals = 4.0, rounding = 1e-6;
  const double made = std::ceil((time - trajectory.time(0)) / time_step - rounding);
  if (!(made >= 1.0 && made < static_cast<double>(settled.size()))) return 0.0;
  const auto number = static_cast<std::size_t>(made);
  return residuals * (settled[number].velocity - settled[number - 1].velocity);
}

MotionDerivatives::MotionDerivatives(const std::shared_ptr<const Network>& network,
                                     const std::shared_ptr<const PluginHost>& plugins, const SimulationOptions& options,
                                     double duration, std::vector<LearnedValues> learned) {
  if (!network) throw Error(ErrorKind::input, "learning: there is no network");
  if (!plugins) throw Error(ErrorKind::input, "learning: there is no plugin host");
  impl_ = std::make_unique<Impl>(network, plugins, options, duration, std::move(learned));
}
MotionDerivatives::~MotionDerivatives() = default;
MotionDerivatives::MotionDerivatives(MotionDerivatives&&) noexcept = default;
MotionDerivatives& MotionDerivatives::operator=(MotionDerivatives&&) noexcept = default;

std::size_t MotionDerivatives::value_count() const noexcept { return impl_->learned.count(); }
VectorXd MotionDerivatives::values_of_network() const { return impl_->network_values; }
void MotionDerivatives::run(const VectorXd& values) { impl_->run(values); }
std::size_t MotionDerivatives::step_count() const noexcept {
  return impl_->trajectory.size() == 0 ? 0 : impl_->trajectory.size() - 1;
}
double MotionDerivatives::time(std::size_t state) const {
  impl_->check_number(state);
  return impl_->trajectory.time(state);
}
Eigen::Matrix3Xd MotionDerivatives::positions(std::size_t state) const {
  return impl_->in_user_order(impl_->at(state).p);
}
Eigen::Matrix3Xd MotionDerivatives::velocities(std::size_t state) const {
  return impl_->in_user_order(impl_->at(state).v);
}
MotionDerivatives::Settled MotionDerivatives::settled_to(std::size_t state) const {
  impl_->check_number(state);
  return impl_->settled[state];
}
void MotionDerivatives::tangent(const MatrixXd& changes, const StateTangents& told) { impl_->tangent(changes, told); }
void MotionDerivatives::set_accuracy(double relative) {
  if (!(relative > 0.0 && relative < 1.0))
    throw Error(ErrorKind::input, fmt::format("learning: an accuracy of {} is not between 0 and 1", relative));
  impl_->accuracy = relative;
}
std::vector<Event> MotionDerivatives::events() const { return impl_->events; }
void MotionDerivatives::set_memory(std::size_t bytes) { impl_->trajectory.set_memory(bytes); }
MotionDerivatives::Kept MotionDerivatives::kept() const noexcept {
  const learning::Trajectory::Use& use = impl_->trajectory.use();
  return {use.most_states, use.most_saved, use.part, use.places, use.steps_again, use.most_bytes};
}
void MotionDerivatives::begin_steps(const VectorXd& values, const MatrixXd& changes) {
  impl_->begin_steps(values, changes);
}
void MotionDerivatives::make_step(const VectorXd& values, const MatrixXd& changes) {
  impl_->make_step(values, changes);
}
void MotionDerivatives::step_tangents(std::size_t state, MatrixXd& positions, MatrixXd& velocities) const {
  positions = impl_->columns_in_user_order(state == 0 ? impl_->dps_before : impl_->dps);
  velocities = impl_->columns_in_user_order(state == 0 ? impl_->dvs_before : impl_->dvs);
}
VectorXd MotionDerivatives::adjoint(const std::function<void(std::size_t, StateChange&)>& add) {
  return impl_->adjoint(add);
}

}  // namespace springnet
