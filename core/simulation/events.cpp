// Changes of the network while it runs: contacts made and released, ruptures, cuts, and the commit of a step.

#include <algorithm>
#include <cmath>

#include "layers/elements.hpp"
#include "simulation/engine.hpp"

namespace springnet {
namespace {

Vector3 at(const springnet_vectors& v, std::uint32_t k) { return {v.x[k], v.y[k], v.z[k]}; }
void put(const springnet_vectors& v, std::uint32_t k, const Vector3& value) {
  v.x[k] = value[0];
  v.y[k] = value[1];
  v.z[k] = value[2];
}

// A node this far behind a surface was not seen to cross it: twice within one step of the reference, say.
constexpr double penetration = 1e-9;

}  // namespace

const std::vector<std::uint32_t>& Engine::rupturing() {
  if (!rupturing_known_) {
    rupturing_ = layers::rupturing_springs(layout_);
    rupturing_known_ = true;
  }
  return rupturing_;
}

const std::vector<Engine::EventSource>& Engine::event_sources() {
  if (sources_revision_ != revision_) {
    sources_.clear();
    const auto planes = static_cast<std::uint32_t>(contact_.planes().size());
    for (std::uint32_t k = 0; planes > 0 && k < layout_.node_count(); ++k) {
      if (contact_.fixed()[k] != 0) continue;
      if (contact_.held()[k] != 0)
        sources_.push_back({EventSource::Kind::release, k, static_cast<std::uint32_t>(contact_.plane_of(k))});
      else
        for (std::uint32_t j = 0; j < planes; ++j) sources_.push_back({EventSource::Kind::touch, k, j});
    }
    for (const std::uint32_t s : rupturing()) sources_.push_back({EventSource::Kind::rupture, s, 0});
    touch_depth_ = planes > 0 ? contact_tolerance() : 0.0;
    sources_revision_ = revision_;
  }
  return sources_;
}

springnet_status Engine::event_values(const springnet_evaluation& request, double* values, std::int32_t* directions) {
  const std::vector<EventSource>& sources = event_sources();
  const layers::NodeArrays nodes = node_arrays(request.position, request.velocity);
  const layers::ExternalForces external = loads_.external();
  for (std::size_t e = 0; e < sources.size(); ++e) {
    const EventSource& source = sources[e];
    const std::uint32_t k = source.index;
    if (directions != nullptr) directions[e] = source.kind == EventSource::Kind::release ? 1 : -1;
    if (source.kind == EventSource::Kind::touch) {
      // From the contact tolerance on: a node that lies on the surface, up to rounding, has a value above 0 that falls
      // through it when the node sinks in. A value of 0 would not count as a crossing.
      values[e] = contact_.distance(source.plane, {nodes.px[k], nodes.py[k], nodes.pz[k]}) + touch_depth_;
    } else if (source.kind == EventSource::Kind::release) {
      Vector3 force;
      const springnet_status status = evaluator_.evaluate_node(k, request.time, nodes, external, force, message_);
      if (status != SPRINGNET_OK) return status;
      values[e] = contact_.planes()[source.plane].normal.dot(force);
    }
  }
  const std::vector<std::uint32_t>& springs = rupturing();
  return springs.empty() ? SPRINGNET_OK
                         : layers::rupture_margins(layout_, evaluator_.instruction_set(), request.time, nodes, springs,
                                                   values + (sources.size() - springs.size()), message_);
}

void Engine::touch(std::uint32_t node, std::size_t plane, double time, State& state) {
  const Vector3 position = at(state.view.position, node), velocity = at(state.view.velocity, node);
  put(state.view.position, node, position - contact_.distance(plane, position) * contact_.planes()[plane].normal);
  put(state.view.velocity, node, Vector3::Zero());
  contact_.hold(node, static_cast<std::int32_t>(plane), -mass_[node] * velocity);
  note(Event::Kind::touched, time, layout_.ordering().user[node]);
  changed();
}

void Engine::settle_contacts(double time, State& state) {
  const std::vector<Plane>& planes = contact_.planes();
  if (planes.empty()) return;
  const double tolerance = contact_tolerance();
  // A force this small, in units of the force scale, is rounding: a node was just released by it, say.
  const double least_force = 1e-9 * info_.force_scale;
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    for (std::size_t j = 0; j < planes.size() && contact_.constrained()[k] == 0; ++j) {
      if (contact_.distance(j, at(state.view.position, k)) > tolerance) continue;
      const double speed = planes[j].normal.dot(at(state.view.velocity, k));
      Vector3 force = Vector3::Zero();
      springnet_message message{};
      if (speed > 0.0 || (speed == 0.0 && evaluator_.evaluate_node(k, time, state.nodes(), loads_.external(), force,
                                                                   message) != SPRINGNET_OK))
        continue;
      if (speed < 0.0 || planes[j].normal.dot(force) < -least_force) touch(k, j, time, state);
    }
  }
}

springnet_status Engine::fire_events(double time, State& state, const std::int32_t* fired) {
  const std::vector<EventSource> sources = event_sources();
  std::vector<std::uint32_t> broken, touched;
  for (std::size_t e = 0; e < sources.size(); ++e) {
    const EventSource& source = sources[e];
    const std::uint32_t k = source.index;
    bool now = fired[e] != 0;
    if (source.kind == EventSource::Kind::touch) {
      if (contact_.held()[k] != 0) continue;  // two planes at once: the first holds it
      const Plane& plane = contact_.planes()[source.plane];
      const double distance = contact_.distance(source.plane, at(state.view.position, k));
      now = now || (distance <= touch_depth_ && plane.normal.dot(at(state.view.velocity, k)) < 0.0);
      if (now) {
        touch(k, source.plane, time, state);
        touched.push_back(k);
      }
    } else if (!now) {
      continue;
    } else if (source.kind == EventSource::Kind::release) {
      contact_.release(k);
      note(Event::Kind::released, time, layout_.ordering().user[k]);
      changed();
    } else {
      broken.push_back(k);
    }
  }
  if (!broken.empty()) remove(broken, Event::Kind::ruptured, time);
  // A node that is pulled away where it touches does not stay.
  const layers::ExternalForces external = loads_.external();
  for (const std::uint32_t k : touched) {
    Vector3 force;
    const springnet_status status = evaluator_.evaluate_node(k, time, state.nodes(), external, force, message_);
    if (status != SPRINGNET_OK) return status;
    if (contact_.planes()[static_cast<std::size_t>(contact_.plane_of(k))].normal.dot(force) > 0.0) {
      contact_.release(k);
      note(Event::Kind::released, time, layout_.ordering().user[k]);
      changed();
    }
  }
  return evaluator_.evaluate(time, state.nodes(), external, state.forces(), {}, message_);
}

void Engine::stop_penetration(double time, State& state) {
  for (std::size_t j = 0; j < contact_.planes().size(); ++j) {
    for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
      if (contact_.constrained()[k] != 0) continue;
      if (contact_.distance(j, at(state.view.position, k)) < -penetration * info_.length_scale)
        touch(k, j, time, state);
    }
  }
}

std::size_t Engine::remove(const std::vector<std::uint32_t>& springs, Event::Kind kind, double time) {
  const std::vector<std::uint32_t> removed = layout_.remove(springs);
  for (const std::uint32_t s : removed) note(kind, time, s);
  if (!removed.empty()) {
    rupturing_known_ = false;
    linearisation_.topology_changed();
    changed();
  }
  return removed.size();
}

std::size_t Engine::cut(const std::vector<std::uint32_t>& springs) { return remove(springs, Event::Kind::cut, time_); }

std::size_t Engine::cut(const CuttingPolygon& polygon) {
  std::vector<std::uint32_t> crossed;
  for (std::uint32_t s = 0; s < layout_.spring_count(); ++s)
    if (layout_.alive(s) &&
        polygon.crosses(at(state_.view.position, layout_.first(s)), at(state_.view.position, layout_.second(s))))
      crossed.push_back(s);
  return cut(crossed);
}

void Engine::perform_due_cuts() {
  for (ScheduledCut& scheduled : cuts_) {
    if (scheduled.done || scheduled.time > time_ + time_resolution_) continue;
    scheduled.done = true;
    cut(scheduled.springs);
    if (scheduled.polygon) cut(*scheduled.polygon);
  }
}

springnet_status Engine::perform_due_ruptures() {
  const std::vector<std::uint32_t>& springs = rupturing();
  if (springs.empty()) return SPRINGNET_OK;
  std::vector<double> margins(springs.size());
  const springnet_status status = layers::rupture_margins(layout_, evaluator_.instruction_set(), time_, state_.nodes(),
                                                          springs, margins.data(), message_);
  if (status != SPRINGNET_OK) return status;
  std::vector<std::uint32_t> broken;
  for (std::size_t i = 0; i < springs.size(); ++i)
    if (margins[i] <= 0.0) broken.push_back(springs[i]);
  remove(broken, Event::Kind::ruptured, time_);
  return SPRINGNET_OK;
}

double Engine::next_discontinuity(double time) const noexcept {
  double next = loads_.next_switch(time);
  for (const ScheduledCut& cut : cuts_)
    if (!cut.done && cut.time > time) next = std::min(next, cut.time);
  return next;
}

springnet_status Engine::commit(double time, State& state) {
  state_.swap(state);
  time_ = time;
  forces_stale_ = state_.view.force_is_current == 0;
  for (std::uint32_t k = 0; !swept_ && k < layout_.node_count(); ++k) {
    // What a solver left of rounding in unknowns that do not move.
    if (contact_.fixed()[k] != 0) put(state_.view.position, k, at(state.view.position, k));
    if (contact_.constrained()[k] != 0) put(state_.view.velocity, k, Vector3::Zero());
  }
  if (swept_) {
    swept_ = false;
    std::vector<std::uint32_t> touched, released;
    contact_.commit_sweep(touched, released);
    for (const std::uint32_t k : touched) note(Event::Kind::touched, time, layout_.ordering().user[k]);
    for (const std::uint32_t k : released) note(Event::Kind::released, time, layout_.ordering().user[k]);
    if (!touched.empty() || !released.empty()) ++revision_;
  } else {
    stop_penetration(time, state_);
  }
  const springnet_status status = perform_due_ruptures();
  perform_due_cuts();
  return status;
}

}  // namespace springnet
