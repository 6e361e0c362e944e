// Time steps that are divided where events are located. With a change of the state and of the time t0 at its start, the
// end of a part changes by that and by the time t1 at which an event happens. This follows from the event's value g,
// which is 0 there: dt1 = -(dg at this time) / (dg/dt1). Then the event changes the state, and the next part starts at
// t1. At the end of the time step, and where cuts, loads and motions jump, times stay.

#include "learning/motion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/node_vectors.hpp"
#include "simulation/model.hpp"

namespace springnet {

using Eigen::Index;
using Eigen::RowVectorXd;
using Eigen::VectorXd;
using learning::EventCondition;
using learning::LocatedEvent;
using learning::node_of;
using learning::NodeJump;
using learning::put_node;
using learning::StepPart;

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Derivatives by time that have no formula, of loads and of accelerations of surfaces, are central differences over
// twice this share of the time step: of an error of 1e-8 times the square of the angle by which they swing in a step.
constexpr double share_of_step = 1e-4;

Vector6 state_of(const Eigen::Ref<const VectorXd>& p, const Eigen::Ref<const VectorXd>& v, std::uint32_t node) {
  Vector6 result;
  result << node_of(p, node), node_of(v, node);
  return result;
}
void put_state(Eigen::Ref<VectorXd> p, Eigen::Ref<VectorXd> v, std::uint32_t node, const Vector3& position,
               const Vector3& velocity) {
  put_node(p, node, position);
  put_node(v, node, velocity);
}
void put_state(Eigen::Ref<VectorXd> p, Eigen::Ref<VectorXd> v, std::uint32_t node, const Vector6& state) {
  put_state(p, v, node, state.head<3>(), state.tail<3>());
}

std::string what_happens(LocatedEvent::Kind kind) {
  switch (kind) {
    case LocatedEvent::Kind::touch:
      return "touch";
    case LocatedEvent::Kind::release:
      return "release";
    case LocatedEvent::Kind::slip:
      return "slip";
    case LocatedEvent::Kind::rest:
      return "end of the slip";
    case LocatedEvent::Kind::several:
      return "several events at once";
    case LocatedEvent::Kind::seam:
      return "way over an edge";
    case LocatedEvent::Kind::slow:
    case LocatedEvent::Kind::quick:
    case LocatedEvent::Kind::stall:
      return "change of the slip";
    default:
      return "rupture";
  }
}

}  // namespace

void MotionDerivatives::Impl::refuse(const LocatedEvent& event, double time, const std::string& what) const {
  std::string who =
      fmt::format("{} {}", event.kind == LocatedEvent::Kind::spring_rupture ? "spring" : "element", event.index);
  if (event.is_of_node())
    who = fmt::format("node {} with {}", engine.model().user_number(event.index),
                      constraints->engine().model().contact.name_of(static_cast<std::size_t>(event.surface)));
  throw Error(ErrorKind::simulation, fmt::format("learning: the {} of {} at {:g} s is not differentiated{}; set events "
                                                 "= \"stepwise\"",
                                                 what_happens(event.kind), who, time, what));
}

void MotionDerivatives::Impl::refuse(const Step& step, const std::string& what) const {
  if (step.event != nullptr) refuse(*step.event, step.until.time, what);
  throw Error(ErrorKind::simulation,
              fmt::format("learning: the part of a step to {:g} s, which starts at an event, is not differentiated{}; "
                          "set events = \"stepwise\"",
                          step.until.time, what));
}

void MotionDerivatives::Impl::refuse_times(const Step& step, std::uint32_t node) const {
  const auto number = engine.model().user_number(node);
  const std::string at_the_same_time =
      constraints->is_rigid(node)
          ? fmt::format(
                ", while the rigid connections of node {} touch a surface that moves, or join it to a node that "
                "is moved",
                number)
          : fmt::format(", while node {} is in a vertex of surfaces that move", number);
  refuse(step, at_the_same_time);
}

// ---- what the steps were, while they are made the first time --------------------------------------------------------

void MotionDerivatives::Impl::take_part(const learning::PartRecorder::Committed& committed) {
  const StepPart& part = committed.part;
  if (recorder.parts().size() == 1) parts_before.push_back(part_count);
  for (const LocatedEvent& each : part.events)
    if (each.is_of_node() && constraints->is_rigid(each.index))
      refuse(each, part.time, ", as the node is rigidly connected");
  const std::size_t first = part_count + 1;
  part_count += std::max<std::size_t>(1, part.events.size());
  if (committed.decided) decided.insert(first);
  const auto of = [&](const Event& event) {
    const auto found = std::find_if(part.events.begin(), part.events.end(), [&](const LocatedEvent& each) {
      return !each.is_of_node() && each.index == event.index &&
             event.element == (each.kind == LocatedEvent::Kind::element_rupture);
    });
    return found == part.events.end() ? part_count : first + static_cast<std::size_t>(found - part.events.begin());
  };
  const Event* const jammed = removals.take(simulation.events(), first, part.time, of);
  if (jammed != nullptr)
    throw Error(
        ErrorKind::simulation,
        fmt::format("learning: node {}, which is jammed at {:g} s, is not differentiated", jammed->index, part.time));
  scene_changes.take(part_count, part.time);
  if (!constraints) return;
  learning::ContactHistory& history = constraints->history();
  const Model& model = committed.engine.model();
  if (committed.decided) {
    history.record(simulation, first);
  } else {
    history.keep(simulation, first, committed.within);
    for (std::size_t i = 0; i < part.events.size(); ++i)
      if (part.events[i].is_of_node()) history.change(first + i, part.events[i].index, part.events[i].after);
  }
  const learning::Touches now = learning::contacts_of(model.contact, model.node_count());
  if (const auto node = learning::differing_node(now, history.at(part_count)))
    throw Error(ErrorKind::simulation,
                fmt::format("learning: the contact of node {}, which changes at {:g} s without an event, is not "
                            "differentiated; set events = \"stepwise\"",
                            model.user_number(*node), part.time));
  std::vector<learning::Slipping> slips;
  for (const auto& [node, touch] : now)
    if (touch.slides && model.contact.slip_phase(node) != Contact::Slip::ongoing)
      slips.push_back({node, model.contact.slip(node), model.contact.slip_phase(node)});
  for (std::size_t number = first; number <= part_count; ++number) {
    std::vector<learning::Slipping> own = slips;
    // Of those whose slip ends at the same time only rounding tells the direction of what is left of it.
    for (std::size_t i = number - first + 1; i < part.events.size(); ++i)
      if (const LocatedEvent& later = part.events[i];
          later.kind == LocatedEvent::Kind::rest && !later.slip.isZero() && !later.after.slides)
        own.push_back({later.index, later.slip, Contact::Slip::ending});
    history.set_slips(number, std::move(own));
  }
}

MotionDerivatives::Impl::Parts MotionDerivatives::Impl::parts_of(std::size_t k) {
  const auto [from, until] = trajectory.step(k);
  Parts result;
  std::size_t number = locates ? parts_before[k - 1] : k - 1;
  if (until.parts.empty()) {
    result.steps.push_back(part(number + 1, from, until));
    return result;
  }
  const State* at = &from;
  bool after_event = false;
  const auto add = [&](const State& end, const LocatedEvent* event, bool instant) {
    Step& step = result.steps.emplace_back(part(++number, *at, end));
    step.starts_at_event = after_event;
    step.event = event;
    step.is_instant = instant;
    after_event = event != nullptr;
    at = &end;
  };
  for (std::size_t i = 0; i < until.parts.size(); ++i) {
    const StepPart& own = until.parts[i];
    const State* after = &until;
    if (i + 1 < until.parts.size()) after = &result.states.emplace_back(State{own.time, own.p, own.v, own.z, {}});
    if (own.events.empty()) {
      add(*after, nullptr, false);
      continue;
    }
    State found{own.time, after->p, after->v, after->z, {}};
    for (const LocatedEvent& each : own.events)
      if (each.is_of_node()) put_state(found.p, found.v, each.index, each.p, each.v);
    for (std::size_t e = 0; e < own.events.size(); ++e) {
      const LocatedEvent& event = own.events[e];
      add(result.states.emplace_back(found), &event, e > 0);
      if (event.is_of_node()) put_state(found.p, found.v, event.index, event.next_p, event.next_v);
    }
    at = after;
  }
  if (after_event) add(until, nullptr, true);
  return result;
}

// ---- times ----------------------------------------------------------------------------------------------------------

// Where the step's outputs were found.
MotionDerivatives::Impl::ByTimes MotionDerivatives::Impl::find_times(const Step& step) {
  const double h = step.until.time - step.from.time, d = std::min(0.5 * h, share_of_step * time_step);
  VectorXd at_start_a = VectorXd::Zero(size()), at_end_a, at_end_z;
  const auto evaluate = [&](double from, double until) {
    host.begin_step(from, until);
    springnet_evaluation end = end_of(step, until - from), start = evaluation(step.from);
    end.time = until;
    start.time = from;
    at_end_a = accelerations(host, end);
    at_end_z = internal.at_end(host, end, until - from);
    if (step.c > 0.0) at_start_a = accelerations(host_at_start(step.number - 1, from, until), start);
  };
  const auto over_step = [&] { return VectorXd(step.c * at_start_a + step.w * at_end_a); };
  ByTimes result;
  const double from = step.from.time, until = step.until.time;
  const auto difference = [&](double start, double end, ByTime& to) {
    evaluate(from + start, until + end);
    const VectorXd after = over_step(), after_z = at_end_z;
    evaluate(from - start, until - end);
    to.free = (after - over_step()) / (2.0 * (start + end));
    to.z = (after_z - at_end_z) / (2.0 * (start + end));
  };
  difference(d, 0.0, result.start);
  difference(0.0, d, result.end);
  evaluate(from, until);
  const VectorXd mean = over_step() / h;
  result.start.free -= mean;
  result.end.free += mean;
  result.end.p = (1.0 - theta) * step.from.v + theta * step.until.v;
  result.end.v = VectorXd::Zero(size());
  result.start.p = -result.end.p;
  result.start.v = result.end.v;
  for (const bool ends : {false, true}) {
    ByTime& own = ends ? result.end : result.start;
    if (const auto node = outputs.write_times(ends, own.p, own.v)) refuse_times(step, *node);
    for (VectorXd* each : {&own.free, &own.p, &own.v}) clear_pinned(*each);
  }
  const springnet_network& network = host.network();
  for (std::uint32_t k = 0; k < nodes; ++k)
    if (network.fixed[k] != 0) put_state(result.end.p, result.end.v, k, node_of(step.until.v, k), node_of(at_end_a, k));
  begin_step(step);
  return result;
}

// The host asks for a step that ends later; an instant has the loads of the time before it.
double MotionDerivatives::Impl::begin_of(const Step& step) const {
  return step.is_instant ? step.until.time - share_of_step * time_step : step.from.time;
}

// No time passes, unless its start and end change.
void MotionDerivatives::Impl::pass_instant(const Step& step) {
  const sdk::Host& of = host_at_start(step.number - 1, begin_of(step), step.until.time);
  const VectorXd a = accelerations(of, evaluation(step.from)), rates = rates_in_instant(step, a);
  for (Index j = 0; j < dps.cols(); ++j) {
    const double longer = end_time_changes[j] - start_time_changes[j];
    dps.col(j) += longer * step.from.v;
    dvs.col(j) += longer * a;
    internal.change(j) += longer * rates;
  }
}

VectorXd MotionDerivatives::Impl::rates_in_instant(const Step& step, const VectorXd& a) {
  if (!internal.any()) return {};
  internal.start_at(nodes_at(step.from), step.from.z);
  host.begin_step(begin_of(step), step.until.time);
  return internal.rates(host, evaluation(step.from), a, share_of_step * time_step);
}

// ---- events ---------------------------------------------------------------------------------------------------------

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
  const Contact& contact = constraints->engine().model().contact;
  const double h = std::max(step.until.time - step.from.time, share_of_step * time_step);
  const learning::PlacedTime at{step.until.time, share_of_step * time_step,
                                [&](double time) { return contact.at(just_before(time, h)); }};
  const std::uint32_t k = event.index;
  const auto own = learning::condition_of(contact, at, event, node_of(accelerations(host, end), k));
  if (!own) refuse(step, "");
  put_state(result.by_position, result.by_velocity, k, own->by_position, own->by_velocity);
  result.by_time = own->by_time;
  if (own->by_friction != 0.0) result.by_values = learned.friction_gradient(event.surface, own->by_friction);
  if (own->by_acceleration.isZero(0.0)) return result;
  VectorXd unused = VectorXd::Zero(size());
  result.by_acceleration.setZero(size());
  put_state(result.by_acceleration, unused, k, own->by_acceleration, Vector3::Zero());
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
    host.begin_step(step.is_instant ? then.time - share_of_step * time_step : step.from.time, then.time);
    return accelerations(host, then);
  };
  const VectorXd after = later(d), before = later(-d);
  result.by_time += result.by_acceleration.dot(after - before) / (2.0 * d);
  host.begin_step(begin_of(step), step.until.time);
  return result;
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

NodeJump MotionDerivatives::Impl::jump_of(const Step& step) {
  if (!step.event->is_of_node()) return {};
  const double h = std::max(step.until.time - step.from.time, share_of_step * time_step);
  const Contact& contact = constraints->engine().model().contact;
  const auto result = learning::jump_of(contact, *contact.at(just_before(step.until.time, h)), *step.event, time_step);
  if (!result) refuse(step, "");
  return *result;
}

// ---- forwards -------------------------------------------------------------------------------------------------------

// With a column more, for a change of the time of its event alone.
void MotionDerivatives::Impl::part_forwards(const Step& step) {
  set_for_step(step.number);
  if (step.event == nullptr && !step.starts_at_event) return step_forwards(step);
  const Index columns = event_time_changes.size(), with = columns + (step.event != nullptr ? 1 : 0);
  for (Eigen::MatrixXd* each : {&dps, &dvs, &changes}) {
    each->conservativeResize(Eigen::NoChange, with);
    each->rightCols(with - columns).setZero();
  }
  internal.resize_changes(with);
  start_time_changes.setZero(with);
  end_time_changes.setZero(with);
  start_time_changes.head(columns) = event_time_changes;
  if (step.event != nullptr) end_time_changes[columns] = 1.0;
  if (step.is_instant)
    pass_instant(step);
  else
    step_forwards(step);
  start_time_changes.resize(0);
  end_time_changes.resize(0);
  event_time_changes.setZero();
  if (step.event == nullptr) return;

  const EventCondition condition = condition_of(step);
  const VectorXd p = dps.col(columns), v = dvs.col(columns), z = internal.change(columns);
  const double rate = rate_of(step, condition, p, v, z);
  const NodeJump jump = jump_of(step);
  for (Eigen::MatrixXd* each : {&dps, &dvs, &changes}) each->conservativeResize(Eigen::NoChange, columns);
  internal.resize_changes(columns);
  if (condition.by_acceleration.size() > 0) learned.tangents(engine, host, evaluation(step.until), changes, by_values);
  for (Index j = 0; j < columns; ++j) {
    double value = condition.by_position.dot(dps.col(j)) + condition.by_velocity.dot(dvs.col(j)) +
                   condition.by_internal.dot(internal.change(j));
    if (condition.by_values.size() > 0) value += condition.by_values.dot(changes.col(j));
    if (condition.by_acceleration.size() > 0) value += condition.by_acceleration.dot(by_values.col(j));
    event_time_changes[j] = -value / rate;
    dps.col(j) += event_time_changes[j] * p;
    dvs.col(j) += event_time_changes[j] * v;
    internal.change(j) += event_time_changes[j] * z;
    if (!step.event->is_of_node()) continue;
    const std::uint32_t k = step.event->index;
    const Vector6 own = state_of(dps.col(j), dvs.col(j), k);
    Vector6 after = jump.by_state * own + jump.by_time * event_time_changes[j];
    if (learned.has_friction())
      after += jump.by_friction * learned.friction_changes(changes.col(j))[step.event->surface];
    put_state(dps.col(j), dvs.col(j), k, after);
  }
}

// ---- backwards ------------------------------------------------------------------------------------------------------

void MotionDerivatives::Impl::part_backwards(const Step& step) {
  if (step.event == nullptr && !step.starts_at_event) return step_backwards(step);
  if (step.event != nullptr) event_backwards(step);
  if (!step.is_instant) return step_backwards(step);
  if (pending.size() > 0 && step.event == nullptr) start_backwards(step.until, step.number, pending_until);
  set_for_step(step.number);
  const sdk::Host& of = host_at_start(step.number - 1, begin_of(step), step.until.time);
  const VectorXd a = accelerations(of, evaluation(step.from));
  by_event_time = -dp.dot(step.from.v) - dv.dot(a);
  if (internal.any()) by_event_time -= internal.all_weights().dot(rates_in_instant(step, a));
}

// To derivatives by the end of the part as the event found it, from those by what the event left, and by its time.
void MotionDerivatives::Impl::event_backwards(const Step& step) {
  set_for_step(step.number);
  double by_event = by_event_time;
  if (step.event->is_of_node()) {
    const NodeJump jump = jump_of(step);
    const Vector6 weights_of_node = state_of(dp, dv, step.event->index);
    by_event += jump.by_time.dot(weights_of_node);
    if (learned.has_friction())
      learned.add_gradient(learned.friction_gradient(step.event->surface, jump.by_friction.dot(weights_of_node)));
    put_state(dp, dv, step.event->index, jump.by_state.transpose() * weights_of_node);
  }
  const VectorXd sums = learned.cotangent(VectorXd::Zero(size()));  // which the way forwards overwrites
  dps.setZero(size(), 1);
  dvs.setZero(size(), 1);
  changes.setZero(static_cast<Index>(learned.count()), 1);
  internal.begin_changes(1);
  start_time_changes.setZero(1);
  end_time_changes.setOnes(1);
  if (step.is_instant)
    pass_instant(step);
  else
    step_forwards(step);
  start_time_changes.resize(0);
  end_time_changes.resize(0);
  learned.begin_cotangent();
  learned.add_gradient(sums);
  const VectorXd p = dps.col(0), v = dvs.col(0), z = internal.change(0);
  const EventCondition condition = condition_of(step);
  const double rate = rate_of(step, condition, p, v, z);
  by_event += p.dot(dp) + v.dot(dv) + z.dot(internal.all_weights());
  const double share = -by_event / rate;
  dp += share * condition.by_position;
  dv += share * condition.by_velocity;
  internal.all_weights() += share * condition.by_internal;
  if (condition.by_values.size() > 0) learned.add_gradient(share * condition.by_values);
  if (condition.by_acceleration.size() > 0) {
    weights = share * condition.by_acceleration;
    const springnet_evaluation end = evaluation(step.until);
    host.linearise(end);
    learned.add_cotangent(engine, host, end, weights.data());
  }
}

}  // namespace springnet
