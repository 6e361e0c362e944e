#include "workspace.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <springnet/sdk/integrator.hpp>

namespace springnet::recurrent {
namespace {

constexpr double plausible_travel = 4.0;  // of a node to a surface, in units of what its start velocity and force give
constexpr double negligible_travel = 1e-6;  // in units of the length scale

}  // namespace

void copy(const springnet_const_vectors& from, const springnet_vectors& to, std::uint32_t count) noexcept {
  std::copy_n(from.x, count, to.x);
  std::copy_n(from.y, count, to.y);
  std::copy_n(from.z, count, to.z);
}

void Workspace::attach(const springnet_network& network) {
  record.resize(network);
  if (network.surface_count > 0 || network.rigid_count > 0 || network.body_contact_count > 0) {
    free_acceleration_.resize(network.node_count);
    unconstrained_.resize(network.node_count);
    constraint_force_.resize(network.node_count);
    pinned_.resize(network.node_count);
    selected_.reserve(network.node_count);
  }
}

void Workspace::set_free_motion(Step& step) {
  step.free_position = sdk::view(step.start.position);
  step.free_velocity = sdk::view(step.start.velocity);
  const double rest = (1.0 - step.theta) * step.time_constant;
  if (rest == 0.0) return;
  const std::uint32_t count = step.network.node_count;
  free_position_.resize(count);
  free_velocity_.resize(count);
  const auto move = [&](const double* from, const double* rate, double* to) {
    for (std::uint32_t k = 0; k < count; ++k) to[k] = from[k] + rest * rate[k];
  };
  const springnet_vectors &p = step.start.position, &v = step.start.velocity;
  const springnet_const_vectors a = std::as_const(start_acceleration_).view();
  const springnet_vectors moved = free_position_.view(), accelerated = free_velocity_.view();
  move(p.x, v.x, moved.x);
  move(p.y, v.y, moved.y);
  move(p.z, v.z, moved.z);
  move(v.x, a.x, accelerated.x);
  move(v.y, a.y, accelerated.y);
  move(v.z, a.z, accelerated.z);
  step.free_position = sdk::view(moved);
  step.free_velocity = sdk::view(accelerated);
}

void Workspace::know_start_acceleration(const Step& step) {
  if (step.theta == 1.0 || known_ == revisions(step)) return;
  start_acceleration_.resize(step.network.node_count);
  springnet_evaluation evaluation = sdk::evaluation_at(step.from, step.start);
  evaluation.acceleration = start_acceleration_.view();
  host.evaluate(evaluation);
  host.count("evaluations");  // besides the sweeps
  known_ = revisions(step);
}

void Workspace::committed(const Step& step) {
  known_.reset();
  if (!step.evaluated || step.theta == 1.0) return;
  std::swap(start_acceleration_, acceleration_);
  known_ = revisions(step);  // a change by the commit has a later revision
}

springnet_state& Workspace::outputs_in_place(Step& step) const {
  if (step.outputs == nullptr) {
    step.outputs = &state_beside(nullptr);
    copy(sdk::view(step.start.position), step.outputs->position, step.network.node_count);
    copy(sdk::view(step.start.velocity), step.outputs->velocity, step.network.node_count);
  }
  return *step.outputs;
}

springnet_sweep Workspace::sweep_call(const Step& step, const springnet_state& read, const springnet_state& write) {
  auto call = sdk::sized<springnet_sweep>();
  call.time = step.until;
  call.time_constant = step.time_constant;
  call.theta = step.theta;
  call.start_position = sdk::view(step.start.position);
  call.start_velocity = sdk::view(step.start.velocity);
  call.position = sdk::view(read.position);
  call.velocity = sdk::view(read.velocity);
  call.next_position = write.position;
  call.next_velocity = write.velocity;
  call.force = write.force;
  call.contacts = step.decides && !step.waits ? 0 : 1;
  call.internal = step.internal_step(step.compares ? nullptr : write.internal);  // else complete() writes them
  if (step.may_be_constrained()) call.constraint_force = constraint_force_.view();
  return call;
}

void Workspace::evaluate(const Step& step, const springnet_state& at) {
  springnet_evaluation evaluation = step.evaluation_at_end(at);
  evaluation.internal = step.internal_step(&at == &step.start ? nullptr : at.internal);
  evaluation.force = at.force;
  acceleration_.resize(step.network.node_count);  // not before: single sweeps do without
  evaluation.acceleration = acceleration_.view();
  if (step.constrained()) evaluation.free_acceleration = unconstrained_.view();
  host.evaluate(evaluation);
  host.count("evaluations");  // besides the sweeps
}

void Workspace::forget_constraint_force() noexcept {
  for (auto* component : {&constraint_force_.x, &constraint_force_.y, &constraint_force_.z})
    std::fill(component->begin(), component->end(), 0.0);
}

void Workspace::complete(Step& step) {
  if (step.evaluated) return;
  const springnet_state& outputs = *step.outputs;
  evaluate(step, outputs);
  step.residual = std::sqrt(residual(step, outputs).square);
  step.norm = step.time_constant * residual_norm_;
  step.finite = std::isfinite(step.residual);
  step.evaluated = true;
}

void Workspace::find_free_accelerations(const Step& step) {
  const springnet_network& network = step.network;
  const Three free = axes(free_acceleration_.view());
  const ThreeConst bound = axes(std::as_const(acceleration_)), unbound = axes(std::as_const(unconstrained_));
  for (std::uint32_t k = 0; k < network.node_count; ++k) {
    const std::uint8_t status = network.status[k];
    pinned_[k] = status == SPRINGNET_PRESCRIBED || status == SPRINGNET_STICKING ? 1 : 0;
    for (std::size_t axis = 0; axis < 3; ++axis) free[axis][k] = pinned_[k] == 0 ? unbound[axis][k] : bound[axis][k];
  }
}

std::uint32_t Workspace::spurious_contact(const Step& step) {
  const springnet_network& network = step.network;
  if (network.surface_count == 0) return no_node;
  selected_.clear();
  for (std::uint32_t k = 0; k < network.node_count; ++k)
    if (network.status[k] == SPRINGNET_STICKING && network.touching[k] == 0) selected_.push_back(k);
  if (selected_.empty()) return no_node;
  springnet_evaluation evaluation = sdk::evaluation_at(step.from, step.start);
  evaluation.force = free_acceleration_.view();
  host.evaluate_nodes(evaluation, selected_);
  const auto norm = [](double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); };
  for (const std::uint32_t k : selected_) {
    const springnet_vectors &p = step.start.position, &v = step.start.velocity, &next = step.outputs->position;
    const springnet_vectors& u = step.outputs->velocity;  // the surface's
    const Columns& f = free_acceleration_;
    const double travel = norm(next.x[k] - p.x[k], next.y[k] - p.y[k], next.z[k] - p.z[k]);
    const double speed = norm(v.x[k], v.y[k], v.z[k]) + norm(u.x[k], u.y[k], u.z[k]) +
                         step.time_constant * norm(f.x[k], f.y[k], f.z[k]) / network.mass[k];
    // Forces may grow during the step, but not many times.
    if (travel > plausible_travel * step.time_constant * speed + negligible_travel * network.length_scale) return k;
  }
  return no_node;
}

Greatest Workspace::residual(const Step& step, const springnet_state& at) {
  const springnet_network& network = step.network;
  const bool constrained = step.constrained();
  if (constrained) find_free_accelerations(step);
  const Columns& a = constrained ? free_acceleration_ : acceleration_;
  const springnet_const_vectors& v = step.free_velocity;
  const springnet_vectors& u = at.velocity;
  const double h = step.time_constant, theta = step.theta;
  Greatest greatest;
  double sum = 0.0;
  for (std::uint32_t k = 0; k < network.node_count; ++k) {
    if (constrained ? pinned_[k] != 0 : network.fixed[k] != 0) continue;
    const double m = network.mass[k];
    double x = m * ((u.x[k] - v.x[k]) / h - theta * a.x[k]);
    double y = m * ((u.y[k] - v.y[k]) / h - theta * a.y[k]);
    double z = m * ((u.z[k] - v.z[k]) / h - theta * a.z[k]);
    if (constrained) {
      x -= theta * constraint_force_.x[k];
      y -= theta * constraint_force_.y[k];
      z -= theta * constraint_force_.z[k];
    }
    const double square = x * x + y * y + z * z;
    greatest.offer(square, k, network.user_number);
    sum += square / m;
  }
  residual_norm_ = std::sqrt(sum);
  return greatest;
}

}  // namespace springnet::recurrent
