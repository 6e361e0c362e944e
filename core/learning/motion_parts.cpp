// Time steps that are divided where events are located. With a change of the state and of the time t0 at its start, the
// end of a part changes by that and by the time t1 at which an event happens (motion_events.cpp). Then the event
// changes the state, and the next part starts at t1. At the end of the time step, and where cuts, loads and motions
// jump, times stay.

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
using learning::add_to_node;
using learning::LocatedEvent;
using learning::node_of;
using learning::NodeChange;
using learning::put_state;
using learning::StepPart;

namespace {

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
      return "coincidence of events";
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
                ", while the rigid connections of node {} join it to a node that is moved, or have no smooth step",
                number)
          : fmt::format(", while node {} is in a vertex of surfaces that move", number);
  refuse(step, at_the_same_time);
}

void MotionDerivatives::Impl::check_event_of_cluster(const LocatedEvent& event, double time) const {
  if (event.kind == LocatedEvent::Kind::several) refuse(event, time, ", as rigid connections join the nodes");
  constraints->check_touching_cluster(event.index, event.surface, time);
  const auto check_friction = [&](std::int32_t surface) {
    if (surface >= 0 && learned.has_friction_of(surface))
      refuse(event, time, ", as the friction of a surface is not learned from rigidly connected nodes");
  };
  check_friction(event.surface);
  for (const NodeChange& each : event.cluster) {
    if (each.braced)
      refuse(
          event, time,
          fmt::format(", as rigid connections brace node {} against surfaces", engine.model().user_number(each.node)));
    for (const Touch& touch : {each.before, each.after})
      for (const std::int32_t surface : touch.surfaces()) check_friction(surface);
  }
}

// ---- what the steps were, while they are made the first time --------------------------------------------------------

void MotionDerivatives::Impl::take_part(const learning::PartRecorder::Committed& committed) {
  const StepPart& part = committed.part;
  if (recorder.parts().size() == 1) parts_before.push_back(part_count);
  for (const LocatedEvent& each : part.events)
    if (!each.cluster.empty()) check_event_of_cluster(each, part.time);
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
      part.events[i].for_each_node([&](const NodeChange& each) { history.change(first + i, each.node, each.after); });
  }
  const learning::Touches now = learning::contacts_of(model.contact, model.node_count());
  if (const auto node = learning::differing_node(now, history.at(part_count)))
    throw Error(ErrorKind::simulation,
                fmt::format("learning: the contact of node {}, which changes at {:g} s without an event, is not "
                            "differentiated; set events = \"stepwise\"",
                            model.user_number(*node), part.time));
  std::vector<learning::Slipping> slips;
  for (const auto& [node, touch] : now) {
    const Contact::Slip phase = model.contact.slip_phase(node);
    if (!touch.slides || phase == Contact::Slip::ongoing) continue;
    // Accelerations at the start of a step depend on the direction in which it begins, and that on the forces then.
    const bool has_friction = model.constraints.coefficient(node, static_cast<std::size_t>(touch.surface)) > 0.0;
    if (phase == Contact::Slip::starting && has_friction && theta < 1.0 && constraints->is_rigid(node) &&
        !part.events.empty())
      refuse(part.events.back(), part.time,
             fmt::format(", as node {}, which is rigidly connected, begins to slip there, and theta is below 1",
                         model.user_number(node)));
    slips.push_back({node, model.contact.slip(node), phase});
  }
  for (std::size_t number = first; number <= part_count; ++number) {
    std::vector<learning::Slipping> own = slips;
    // Of those whose slip ends at the same time only rounding tells the direction of what is left of it.
    for (std::size_t i = number - first + 1; i < part.events.size(); ++i)
      if (const LocatedEvent& later = part.events[i];
          later.kind == LocatedEvent::Kind::rest && !later.own.slip.isZero() && !later.own.after.slides)
        own.push_back({later.index, later.own.slip, Contact::Slip::ending});
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
      each.for_each_node([&](const NodeChange& of) { put_state(found.p, found.v, of.node, of.p, of.v); });
    for (std::size_t e = 0; e < own.events.size(); ++e) {
      const LocatedEvent& event = own.events[e];
      add(result.states.emplace_back(found), &event, e > 0);
      event.for_each_node([&](const NodeChange& of) { put_state(found.p, found.v, of.node, of.next_p, of.next_v); });
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

void MotionDerivatives::Impl::pass_part(const Step& step) {
  if (step.is_instant)
    pass_instant(step);
  else
    step_forwards(step);
  start_time_changes.resize(0);
  end_time_changes.resize(0);
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
  StartChanges start{Eigen::Matrix3Xd::Zero(3, columns), Eigen::Matrix3Xd::Zero(3, columns), event_time_changes};
  for (Index j = 0; j < columns && step.event != nullptr && step.event->is_of_node(); ++j) {
    start.positions.col(j) = node_of(dps.col(j), step.event->index);
    start.velocities.col(j) = node_of(dvs.col(j), step.event->index);
  }
  pass_part(step);
  event_time_changes.setZero();
  if (step.event == nullptr) return;

  event_forwards(step, columns, start);
}

// ---- backwards ------------------------------------------------------------------------------------------------------

void MotionDerivatives::Impl::part_backwards(const Step& step) {
  if (step.event == nullptr && !step.starts_at_event) return step_backwards(step);
  learning::StartGradient by_start;
  if (step.event != nullptr) by_start = event_backwards(step);
  if (!step.is_instant) {
    step_backwards(step);
    if (step.event == nullptr || !step.event->is_of_node()) return;
    add_to_node(dp, step.event->index, by_start.by_position);
    add_to_node(dv, step.event->index, by_start.by_velocity);
    if (step.starts_at_event) by_event_time += by_start.by_time;
    return;
  }
  if (pending.size() > 0 && step.event == nullptr) start_backwards(step.until, step.number, pending_until);
  set_for_step(step.number);
  const sdk::Host& of = host_at_start(step.number - 1, begin_of(step), step.until.time);
  const VectorXd a = accelerations(of, evaluation(step.from));
  by_event_time = -dp.dot(step.from.v) - dv.dot(a);
  if (internal.any()) by_event_time -= internal.all_weights().dot(rates_in_instant(step, a));
}

}  // namespace springnet
