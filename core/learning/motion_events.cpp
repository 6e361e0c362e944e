// Events that divide time steps: the condition that determines when they happen, and what they make of the state,
// forwards and backwards. With the event's value g, which is 0 when it happens, a change of the motion moves its time
// by dt1 = -(dg at this time) / (dg/dt1).

#include "learning/motion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <springnet/error.hpp>

#include "learning/cluster_event.hpp"
#include "learning/node_vectors.hpp"
#include "simulation/model.hpp"

namespace springnet {

using Eigen::Index;
using Eigen::VectorXd;
using learning::ClusterEvent;
using learning::EventCondition;
using learning::EventJump;
using learning::LocatedEvent;
using learning::node_of;
using learning::NodeChange;
using learning::put_node;
using learning::put_state;

namespace {

// Positions of some nodes, then their velocities, [6 node].
VectorXd states_of(const std::vector<std::uint32_t>& nodes, const Eigen::Ref<const VectorXd>& p,
                   const Eigen::Ref<const VectorXd>& v) {
  const auto size = static_cast<Index>(3 * nodes.size());
  VectorXd result(2 * size);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    result.segment<3>(static_cast<Index>(3 * i)) = node_of(p, nodes[i]);
    result.segment<3>(size + static_cast<Index>(3 * i)) = node_of(v, nodes[i]);
  }
  return result;
}
void put_states(const std::vector<std::uint32_t>& nodes, const VectorXd& states, Eigen::Ref<VectorXd> p,
                Eigen::Ref<VectorXd> v) {
  const auto size = static_cast<Index>(3 * nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    put_state(p, v, nodes[i], states.segment<3>(static_cast<Index>(3 * i)),
              states.segment<3>(size + static_cast<Index>(3 * i)));
}

VectorXd of_nodes(const VectorXd& values, const std::vector<std::uint32_t>& nodes) {
  VectorXd result(static_cast<Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i) result[static_cast<Index>(i)] = values[nodes[i]];
  return result;
}

}  // namespace

// Contacts as they are before the event.
template <class Function>
auto MotionDerivatives::Impl::with_cluster(const Step& step, const Function& function) {
  Engine& of = constraints->engine();
  const double h = std::max(step.until.time - step.from.time, share_of_step * time_step);
  ClusterEvent cluster(
      of, *step.event, {step.until.time, share_of_step * time_step, step.until.p, step.until.v, step.until.z},
      [&](double until) { static_cast<void>(constraints->begin_step(step.number - 1, until - h, until)); },
      [&of, h](double time) { return of.model().contact.at(just_before(time, h)); });
  return function(cluster);
}

std::vector<std::uint32_t> MotionDerivatives::Impl::nodes_of_event(const LocatedEvent& event) {
  std::vector<std::uint32_t> result;
  event.for_each_node([&](const NodeChange& each) { result.push_back(each.node); });
  return result;
}

// ---- when it happens ------------------------------------------------------------------------------------------------

EventCondition MotionDerivatives::Impl::condition_of(const Step& step) {
  const LocatedEvent& event = *step.event;
  const springnet_evaluation end = evaluation(step.until);
  EventCondition result;
  result.by_position.setZero(size());
  result.by_velocity.setZero(size());
  result.by_internal.setZero(internal.count());
  host.begin_step(begin_of(step), step.until.time);
  if (!event.is_of_node()) {
    const Topology::Rupturing& breaking = engine.topology().rupturing();
    const bool is_spring = event.kind == LocatedEvent::Kind::spring_rupture;
    const std::vector<std::uint32_t>& list = is_spring ? breaking.springs : breaking.elements;
    const auto place = std::find(list.begin(), list.end(), event.index) - list.begin();
    const auto number = static_cast<std::size_t>(place) + (is_spring ? 0 : breaking.springs.size());
    result.by_values = learned.event_gradient(host, end, static_cast<std::uint32_t>(number), result.by_position.data(),
                                              result.by_velocity.data(), result.by_time);
    internal.add_margin(end, static_cast<std::uint32_t>(number), result.by_internal);
    return result;
  }
  result.by_acceleration.setZero(size());
  begin_instant(step.until.time);
  add_condition(step, end, result);
  if (result.by_acceleration.isZero(0.0)) {
    result.by_acceleration.resize(0);
    return result;
  }
  host.linearise(end);
  VectorXd by_position(size()), by_velocity(size());
  host.jacobian_transposed_times(result.by_acceleration.data(), by_position.data(), by_velocity.data());
  result.by_position += by_position;
  result.by_velocity += by_velocity;
  internal.weigh_accelerations(end, result.by_acceleration, result.by_internal);
  const double d = step.is_instant ? share_of_step * time_step
                                   : std::min(0.5 * (step.until.time - step.from.time), share_of_step * time_step);
  const auto later = [&](double by) {
    springnet_evaluation then = end;
    then.time += by;
    begin_instant(then.time);
    return accelerations(host, then);
  };
  const VectorXd after = later(d), before = later(-d);
  result.by_time += result.by_acceleration.dot(after - before) / (2.0 * d);
  host.begin_step(begin_of(step), step.until.time);
  return result;
}

// Loads are means over a step; what decides when an event happens are those at that time.
void MotionDerivatives::Impl::begin_instant(double time) { host.begin_step(time - share_of_instant * time_step, time); }

void MotionDerivatives::Impl::add_condition(const Step& step, const springnet_evaluation& end, EventCondition& to) {
  const LocatedEvent& event = *step.event;
  const VectorXd a = accelerations(host, end);
  if (!event.cluster.empty() && ClusterEvent::has_condition(event.kind)) {
    const auto own = with_cluster(step, [&](ClusterEvent& cluster) { return cluster.condition(a); });
    if (!own) refuse(step, ", as the forces in its rigid connections change with a jump or a kink");
    VectorXd by_mass = VectorXd::Zero(static_cast<Index>(nodes));
    Index i = 0;
    event.for_each_node([&](const NodeChange& each) {
      put_state(to.by_position, to.by_velocity, each.node, own->by_position.segment<3>(3 * i),
                own->by_velocity.segment<3>(3 * i));
      put_node(to.by_acceleration, each.node, own->by_acceleration.segment<3>(3 * i));
      by_mass[each.node] = own->by_mass[i++];
    });
    to.by_time = own->by_time;
    to.by_values = learned.mass_gradient(by_mass);
    return;
  }
  const Contact& contact = constraints->engine().model().contact;
  const double h = std::max(step.until.time - step.from.time, share_of_step * time_step);
  const learning::PlacedTime at{step.until.time, share_of_step * time_step,
                                [&](double time) { return contact.at(just_before(time, h)); }};
  const auto own = learning::condition_of(contact, at, event, node_of(a, event.index));
  if (!own) refuse(step, "");
  put_state(to.by_position, to.by_velocity, event.index, own->by_position, own->by_velocity);
  put_node(to.by_acceleration, event.index, own->by_acceleration);
  to.by_time = own->by_time;
  if (own->by_friction != 0.0) to.by_values = learned.friction_gradient(event.surface, own->by_friction);
  if (event.kind == LocatedEvent::Kind::rest && !step.is_instant)
    to.by_start = learning::direction_gradient(contact, *contact.at(just_after(step.from.time)), event,
                                               node_of(step.from.p, event.index), node_of(step.from.v, event.index),
                                               learning::slip_of(contact, *at.placed(at.time), event));
}

double MotionDerivatives::Impl::rate_of(const Step& step, const EventCondition& condition, const VectorXd& p,
                                        const VectorXd& v, const VectorXd& z) const {
  const double result =
      condition.by_position.dot(p) + condition.by_velocity.dot(v) + condition.by_internal.dot(z) + condition.by_time;
  const LocatedEvent::Kind kind = step.event->kind;
  // The direction in which values cross 0.
  const bool rises = kind == LocatedEvent::Kind::release || kind == LocatedEvent::Kind::quick;
  const double towards = kind == LocatedEvent::Kind::seam ? std::abs(result) : rises ? result : -result;
  if (!(towards > 0.0)) refuse(step, ", as its time has no derivative: it comes about without speed");
  return result;
}

// ---- what it makes of the state -------------------------------------------------------------------------------------

EventJump MotionDerivatives::Impl::jump_of(const Step& step) {
  const LocatedEvent& event = *step.event;
  if (!event.is_of_node()) return {};
  const Contact& contact = constraints->engine().model().contact;
  if (!event.cluster.empty()) {
    if (event.kind == LocatedEvent::Kind::stall) refuse(step, ", of a rigidly connected node");
    std::optional<EventJump> result = with_cluster(step, [](ClusterEvent& cluster) { return cluster.jump(); });
    if (!result) refuse(step, ", as what it leaves of the rigid connections changes with a jump or a kink");
    return *std::move(result);
  }
  const double h = std::max(step.until.time - step.from.time, share_of_step * time_step);
  auto result = learning::jump_of(contact, *contact.at(just_before(step.until.time, h)), event, time_step);
  if (!result) refuse(step, "");
  return *std::move(result);
}

void MotionDerivatives::Impl::event_forwards(const Step& step, Index columns, const StartChanges& start) {
  const EventCondition condition = condition_of(step);
  const VectorXd p = dps.col(columns), v = dvs.col(columns), z = internal.change(columns);
  const double rate = rate_of(step, condition, p, v, z);
  const EventJump jump = jump_of(step);
  const std::vector<std::uint32_t> changed = nodes_of_event(*step.event);
  for (Eigen::MatrixXd* each : {&dps, &dvs, &changes}) each->conservativeResize(Eigen::NoChange, columns);
  internal.resize_changes(columns);
  if (condition.by_acceleration.size() > 0) {
    begin_instant(step.until.time);
    learned.tangents(engine, host, evaluation(step.until), changes, by_values);
    host.begin_step(begin_of(step), step.until.time);
  }
  for (Index j = 0; j < columns; ++j) {
    double value = condition.by_position.dot(dps.col(j)) + condition.by_velocity.dot(dvs.col(j)) +
                   condition.by_internal.dot(internal.change(j));
    if (condition.by_values.size() > 0) value += condition.by_values.dot(changes.col(j));
    if (condition.by_acceleration.size() > 0) value += condition.by_acceleration.dot(by_values.col(j));
    value += condition.by_start.by_position.dot(start.positions.col(j)) +
             condition.by_start.by_velocity.dot(start.velocities.col(j)) + condition.by_start.by_time * start.times[j];
    event_time_changes[j] = -value / rate;
    dps.col(j) += event_time_changes[j] * p;
    dvs.col(j) += event_time_changes[j] * v;
    internal.change(j) += event_time_changes[j] * z;
    if (!step.event->is_of_node()) continue;
    VectorXd after = jump.by_state * states_of(changed, dps.col(j), dvs.col(j)) + jump.by_time * event_time_changes[j];
    if (jump.by_mass.size() > 0) after += jump.by_mass * of_nodes(learned.mass_changes(changes.col(j), nodes), changed);
    if (learned.has_friction())
      after += jump.by_friction * learned.friction_changes(changes.col(j))[step.event->surface];
    put_states(changed, after, dps.col(j), dvs.col(j));
  }
}

// To derivatives by the end of the part as the event found it, from those by what the event left, and by its time.
// Returns those by where the part begins.
learning::StartGradient MotionDerivatives::Impl::event_backwards(const Step& step) {
  set_for_step(step.number);
  double by_event = by_event_time;
  if (step.event->is_of_node()) {
    const EventJump jump = jump_of(step);
    const std::vector<std::uint32_t> changed = nodes_of_event(*step.event);
    const VectorXd weights_of_nodes = states_of(changed, dp, dv);
    by_event += jump.by_time.dot(weights_of_nodes);
    if (jump.by_mass.size() > 0) {
      const VectorXd own = jump.by_mass.transpose() * weights_of_nodes;
      VectorXd by_mass = VectorXd::Zero(static_cast<Index>(nodes));
      for (std::size_t i = 0; i < changed.size(); ++i) by_mass[changed[i]] = own[static_cast<Index>(i)];
      learned.add_gradient(learned.mass_gradient(by_mass));
    }
    if (learned.has_friction())
      learned.add_gradient(learned.friction_gradient(step.event->surface, jump.by_friction.dot(weights_of_nodes)));
    put_states(changed, jump.by_state.transpose() * weights_of_nodes, dp, dv);
  }
  const VectorXd sums = learned.cotangent(VectorXd::Zero(size()));  // which the way forwards overwrites
  dps.setZero(size(), 1);
  dvs.setZero(size(), 1);
  changes.setZero(static_cast<Index>(learned.count()), 1);
  internal.begin_changes(1);
  start_time_changes.setZero(1);
  end_time_changes.setOnes(1);
  pass_part(step);
  learned.begin_cotangent();
  learned.add_gradient(sums);
  const VectorXd p = dps.col(0), v = dvs.col(0), z = internal.change(0);
  const EventCondition condition = condition_of(step);
  const double rate = rate_of(step, condition, p, v, z);
  by_event += p.dot(dp) + v.dot(dv) + z.dot(internal.all_weights());
  const double share = -by_event / rate;
  learning::StartGradient by_start = condition.by_start;
  by_start.by_position *= share;
  by_start.by_velocity *= share;
  by_start.by_time *= share;
  dp += share * condition.by_position;
  dv += share * condition.by_velocity;
  internal.all_weights() += share * condition.by_internal;
  if (condition.by_values.size() > 0) learned.add_gradient(share * condition.by_values);
  if (condition.by_acceleration.size() > 0) {
    weights = share * condition.by_acceleration;
    const springnet_evaluation end = evaluation(step.until);
    begin_instant(step.until.time);
    host.linearise(end);
    learned.add_cotangent(engine, host, end, weights.data());
    host.begin_step(begin_of(step), step.until.time);
  }
  return by_start;
}

}  // namespace springnet
