// Contacts made, released, slipping and sticking, as an integrator with events sees them.

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "layers/elements.hpp"
#include "simulation/engine.hpp"
#include "simulation/reactions_at.hpp"
#include "simulation/vectors.hpp"

namespace springnet {
namespace {

// A node this far behind a surface was not seen to cross it: twice within one step of the reference, say.
constexpr double penetration = 1e-9;
// A node that a surface stopped has no speed against it but rounding, in units of the velocity scale.
constexpr double rounding_of_speed = 1e-13;
// What positions of a reference are uncertain by at least, in units of the length scale.
constexpr double uncertain = 1e-8, shallow = 1e-7;
// A surface whose velocity jumps leaves a node behind where that is more than errors of integration, in units of the
// velocity scale.
constexpr double jump = 1e-6;

}  // namespace

const std::vector<Engine::EventSource>& Engine::event_sources() {
  if (sources_revision_ != revision_) {
    sources_.clear();
    const auto surfaces = static_cast<std::uint32_t>(contact_.surfaces().size());
    for (std::uint32_t k = 0; surfaces > 0 && k < layout_.node_count(); ++k) {
      if (contact_.fixed()[k] != 0) continue;
      const Touch touch = contact_.committed(k);
      const auto j = static_cast<std::uint32_t>(touch.surface);
      if (touch.surface >= 0) {
        sources_.push_back({EventSource::Kind::release, k, j});
        if (touch.second >= 0) {
          const auto second = static_cast<std::uint32_t>(touch.second);
          sources_.push_back({EventSource::Kind::release, k, second});
          sources_.push_back({EventSource::Kind::corner, k, second});
        }
        if (touch.second < 0 && contact_.surfaces()[j].friction().kind == Friction::Kind::coulomb)
          sources_.push_back({touch.slides ? EventSource::Kind::stick : EventSource::Kind::slip, k, j});
        if (!touch.slides) continue;
      }
      for (std::uint32_t other = 0; other < surfaces; ++other)
        if (touch.surface < 0 || other != j) sources_.push_back({EventSource::Kind::touch, k, other});
    }
    for (const std::uint32_t s : rupturing().springs) sources_.push_back({EventSource::Kind::rupture, s, 0});
    for (const std::uint32_t e : rupturing().elements) sources_.push_back({EventSource::Kind::element_rupture, e, 0});
    touch_depth_ = surfaces > 0 ? contact_tolerance() : 0.0;
    sources_revision_ = revision_;
  }
  return sources_;
}

springnet_status Engine::event_values(const springnet_evaluation& request, double* values, std::int32_t* directions) {
  const std::vector<EventSource>& sources = event_sources();
  ReactionsAt reactions(*this, request.time, request.position, request.velocity);
  for (std::size_t e = 0; e < sources.size(); ++e) {
    const EventSource& source = sources[e];
    const std::uint32_t k = source.index;
    const bool rises = source.kind == EventSource::Kind::release || source.kind == EventSource::Kind::corner;
    if (directions != nullptr) directions[e] = rises ? 1 : -1;
    if (source.kind == EventSource::Kind::rupture || source.kind == EventSource::Kind::element_rupture) continue;
    const Vector3 p = vector_at(request.position, k);
    const Vector3 n = contact_.normal(source.surface, p);
    if (source.kind == EventSource::Kind::touch) {
      // From the contact tolerance on: a node that lies on the surface, up to rounding, has a value above 0 that falls
      // through it when the node sinks in. A value of 0 would not count as a crossing.
      values[e] = contact_.distance(source.surface, p) + touch_depth_;
    } else if (source.kind == EventSource::Kind::corner) {
      values[e] = std::abs(leaving_speed(contact_.committed(k), p)) - jump * info_.velocity_scale;
    } else if (source.kind == EventSource::Kind::stick) {
      // The slip in the direction that it had when the state was last committed.
      values[e] = contact_.slip(k).dot(vector_at(request.velocity, k) - contact_.placement(source.surface).velocity) -
                  contact_.rest_speed();
    } else {
      Vector3 reaction;
      const springnet_status status = reactions.of(k, reaction);
      if (status != SPRINGNET_OK) return status;
      const double pressing = pressing_of(k, source.surface, p, reaction);
      values[e] = source.kind == EventSource::Kind::release
                      ? -pressing
                      : contact_.surfaces()[source.surface].friction().coefficient * pressing -
                            (reaction - pressing * n).norm();
    }
  }
  const std::size_t breaking = rupturing().count();
  return breaking == 0 ? SPRINGNET_OK
                       : rupture_margins(request.time, node_arrays(request.position, request.velocity),
                                         values + (sources.size() - breaking));
}

// What of a reaction is a surface's: all of it along the normal, or, of a node between two surfaces, the share of this
// one where normal forces of both make up the reaction (least squares; what is left is along both).
double Engine::pressing_of(std::uint32_t node, std::size_t surface, const Vector3& position,
                           const Vector3& reaction) const {
  const Touch touch = contact_.committed(node);
  const Vector3 n = contact_.normal(surface, position);
  const double along = n.dot(reaction);
  if (touch.second < 0) return along;
  const auto a = static_cast<std::size_t>(touch.surface), b = static_cast<std::size_t>(touch.second);
  const Vector3 other = contact_.normal(surface == a ? b : a, position);
  const double cosine = n.dot(other), square = 1.0 - cosine * cosine;
  return square > 1e-12 ? (along - cosine * other.dot(reaction)) / square : along;
}

// Contact without restitution: the node loses what its velocity has against the surface, by friction also along it.
void Engine::touch(std::uint32_t node, std::size_t surface, double time, State& state) {
  const Vector3 position = contact_.onto(surface, vector_at(state.view.position, node));
  const Vector3 velocity = vector_at(state.view.velocity, node), w = contact_.placement(surface).velocity;
  const Touch before = contact_.committed(node);
  Friction friction = contact_.surfaces()[surface].friction();
  // A node that slides into a second surface is held there: it has nowhere to go but along both.
  if (before.surface >= 0) friction.kind = Friction::Kind::held;
  const ContactAnswer answer =
      answer_contact(Matrix3::Identity() / mass_[node], velocity - w, contact_.normal(surface, position), friction);
  // At rest along the surface friction holds it, for as long as it can.
  const bool sticks =
      answer.sticks || (friction.kind == Friction::Kind::coulomb && answer.velocity.norm() <= contact_.rest_speed());
  put_vector(state.view.position, node, position);
  put_vector(state.view.velocity, node, sticks ? w : Vector3(w + answer.velocity));
  contact_.touch(node, {static_cast<std::int32_t>(surface), !sticks, before.surface}, answer.impulse);
  if (!sticks) contact_.set_slip(node, answer.velocity.normalized());
  note(Event::Kind::touched, time, layout_.ordering().user[node]);
  changed();
}

// From one of two surfaces: the other goes on as it does with its friction.
void Engine::let_go_of_one(std::uint32_t node, std::size_t surface, double time) {
  const Touch touch = contact_.committed(node);
  const std::int32_t left = touch.surface == static_cast<std::int32_t>(surface) ? touch.second : touch.surface;
  const Friction::Kind kind = contact_.surfaces()[static_cast<std::size_t>(left)].friction().kind;
  contact_.touch(node, {left, kind == Friction::Kind::none}, Vector3::Zero());
  note(Event::Kind::released, time, layout_.ordering().user[node]);
  changed();
}

double Engine::leaving_speed(const Touch& touch, const Vector3& position) const {
  const auto first = static_cast<std::size_t>(touch.surface), second = static_cast<std::size_t>(touch.second);
  return contact_.normal(second, position)
      .dot(contact_.placement(first).velocity - contact_.placement(second).velocity);
}

void Engine::turn_corner(std::uint32_t node, double time, State& state) {
  const Touch touch = contact_.committed(node);
  const auto second = static_cast<std::size_t>(touch.second);
  if (leaving_speed(touch, vector_at(state.view.position, node)) > 0.0) {
    let_go_of_one(node, second, time);
    return;
  }
  contact_.touch(node, {touch.second, false, touch.surface}, Vector3::Zero());
  put_vector(state.view.velocity, node, contact_.placement(second).velocity);
  changed();
}

void Engine::let_go(std::uint32_t node, double time) {
  contact_.release(node);
  note(Event::Kind::released, time, layout_.ordering().user[node]);
  changed();
}

void Engine::leave_surfaces(double from) {
  std::vector<Vector3> before;
  contact_.set_time(just_before(time_, time_ - from));
  for (std::size_t j = 0; j < contact_.surfaces().size(); ++j) before.push_back(contact_.placement(j).velocity);
  contact_.set_time(just_after(time_));
  for (std::uint32_t k = 0; !before.empty() && k < layout_.node_count(); ++k) {
    const Touch touch = contact_.committed(k);
    if (touch.surface < 0) continue;
    const auto j = static_cast<std::size_t>(touch.surface);
    if (contact_.surfaces()[j].friction().kind == Friction::Kind::held) continue;
    const Vector3 velocity = touch.slides ? vector_at(state_.view.velocity, k) : before[j];
    const double apart =
        contact_.normal(j, vector_at(state_.view.position, k)).dot(velocity - contact_.placement(j).velocity);
    if (!(apart > jump * info_.velocity_scale)) continue;
    put_vector(state_.view.velocity, k, velocity);
    if (touch.second >= 0)
      let_go_of_one(k, j, time_);
    else
      let_go(k, time_);
  }
}

// A node that friction cannot hold: it goes where that force does not let it go.
void Engine::slip(std::uint32_t node, const Vector3& reaction, double time, const State& state) {
  const Touch touch = contact_.committed(node);
  const Vector3 n = contact_.normal(static_cast<std::size_t>(touch.surface), vector_at(state.view.position, node));
  contact_.set_slip(node, -(reaction - n * n.dot(reaction)).normalized());
  contact_.touch(node, {touch.surface, true}, Vector3::Zero());
  note(Event::Kind::slipped, time, layout_.ordering().user[node]);
  changed();
}

// A node whose slip came to an end, turned round within a step, or turned by a right angle since its direction was
// noted. In the first two cases it sticks, if friction can hold it.
springnet_status Engine::stick(std::uint32_t node, double time, State& state) {
  const Touch touch = contact_.committed(node);
  const auto j = static_cast<std::size_t>(touch.surface);
  const Vector3 n = contact_.normal(j, vector_at(state.view.position, node));
  const Vector3 relative = vector_at(state.view.velocity, node) - contact_.placement(j).velocity;
  const Vector3 along = relative - n * n.dot(relative);
  changed();
  // At the root of the event there is nothing left along the old direction; anything else is what a step that went past
  // it made of the slip.
  const double rest = contact_.rest_speed();
  if (along.norm() > 2.0 * rest && std::abs(contact_.slip(node).dot(along) - rest) <= rest) {
    contact_.set_slip(node, along.normalized());
    return SPRINGNET_OK;
  }
  put_vector(state.view.velocity, node, contact_.placement(j).velocity);
  contact_.touch(node, {touch.surface, false}, Vector3::Zero());
  note(Event::Kind::stuck, time, layout_.ordering().user[node]);
  Vector3 reaction;
  ReactionsAt reactions(*this, time, read_only(state.view.position), read_only(state.view.velocity));
  if (const springnet_status status = reactions.of(node, reaction); status != SPRINGNET_OK) return status;
  const double pressing = n.dot(reaction);
  if ((reaction - pressing * n).norm() > contact_.surfaces()[j].friction().coefficient * pressing)
    slip(node, reaction, time, state);
  return SPRINGNET_OK;
}

springnet_status Engine::departure(ReactionsAt& at, std::uint32_t node, std::size_t surface, const State& state,
                                   Departure& result) {
  const Vector3 p = vector_at(state.view.position, node);
  const Vector3 n = contact_.normal(surface, p);
  const Vector3 relative = vector_at(state.view.velocity, node) - contact_.placement(surface).velocity;
  Vector3 acceleration = Vector3::Zero();
  const springnet_status status = at.acceleration(node, acceleration);
  // Beside the acceleration that keeps a node with its velocity along the surface at its distance. Its own is its
  // neuron's: in a viscous medium it is not that of the net force alone.
  const double needed = n.dot(contact_.placement(surface).acceleration) - contact_.turning(surface, p, relative);
  result = {n.dot(relative), n.dot(acceleration) - needed};
  return status;
}

bool Engine::turns_round(const Departure& departure) const noexcept {
  return departure.speed > 0.0 ||
         (departure.acceleration > 0.0 &&
          departure.speed * departure.speed <= 2.0 * departure.acceleration * uncertain * info_.length_scale);
}

springnet_status Engine::settle_contacts(double time, State& state) {
  const std::size_t surfaces = contact_.surfaces().size();
  if (surfaces == 0) return SPRINGNET_OK;
  const double tolerance = contact_tolerance();
  // A force this small, in units of the force scale, is rounding: a node was just released by it, say.
  const double least_force = 1e-9 * info_.force_scale;
  const double no_speed = rounding_of_speed * info_.velocity_scale;
  std::optional<ReactionsAt> at;
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    if (contact_.fixed()[k] != 0) continue;
    for (std::size_t j = 0; j < surfaces && contact_.committed(k).surface < 0; ++j) {
      if (contact_.distance(j, vector_at(state.view.position, k)) > tolerance) continue;
      if (!at) at.emplace(*this, time, read_only(state.view.position), read_only(state.view.velocity));
      Departure departs;
      const springnet_status status = this->departure(*at, k, j, state, departs);
      if (departs.speed > no_speed || (departs.speed >= -no_speed && status != SPRINGNET_OK)) continue;
      if (departs.speed < -no_speed || mass_[k] * departs.acceleration < -least_force) {
        touch(k, j, time, state);
        if (rigid_.any()) at.reset();  // what hangs on the node rigidly moves otherwise now
      }
    }
  }
  return release_grip(time, state);
}

springnet_status Engine::release_grip(double time, const State& state) {
  // A force this small, in units of the force scale, is rounding.
  const double least_force = 1e-9 * info_.force_scale;
  std::optional<ReactionsAt> reactions;
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    const Touch touch = contact_.committed(k);
    if (touch.surface < 0 || touch.slides || touch.second >= 0) continue;
    const auto j = static_cast<std::size_t>(touch.surface);
    if (contact_.surfaces()[j].friction().kind != Friction::Kind::coulomb) continue;
    Vector3 reaction;
    if (!reactions) reactions.emplace(*this, time, read_only(state.view.position), read_only(state.view.velocity));
    if (const springnet_status status = reactions->of(k, reaction); status != SPRINGNET_OK) return status;
    const Vector3 n = contact_.normal(j, vector_at(state.view.position, k));
    const double pressing = n.dot(reaction);
    if (pressing > 0.0 &&
        (reaction - pressing * n).norm() > contact_.surfaces()[j].friction().coefficient * pressing + least_force) {
      slip(k, reaction, time, state);
      reactions.reset();  // what hangs on the node rigidly has other reactions now
    }
  }
  return SPRINGNET_OK;
}

springnet_status Engine::fire(const EventSource& source, double time, State& state,
                              std::vector<std::uint32_t>& touched) {
  const std::uint32_t k = source.index;
  const Touch now = contact_.committed(k);
  const auto surface = static_cast<std::int32_t>(source.surface);
  const bool same = now.surface == surface || (now.second >= 0 && now.second == surface);
  switch (source.kind) {
    case EventSource::Kind::touch:
      if (now.surface >= 0 && !now.slides) break;  // two surfaces at once: the first holds it
      {
        // Just released: what the distance is uncertain by crossed the tolerance once more.
        ReactionsAt reactions(*this, time, read_only(state.view.position), read_only(state.view.velocity));
        Departure departs;
        const springnet_status status = departure(reactions, k, source.surface, state, departs);
        if (status != SPRINGNET_OK) return status;
        if (now.surface < 0 && turns_round(departs)) break;
        if (departs.speed > 0.0) break;
        touch(k, source.surface, time, state);
        touched.push_back(k);
        break;
      }
    case EventSource::Kind::release:
      if (same && now.second >= 0)
        let_go_of_one(k, source.surface, time);
      else if (same)
        let_go(k, time);
      break;
    case EventSource::Kind::corner:
      if (same && now.second >= 0) turn_corner(k, time, state);
      break;
    case EventSource::Kind::stick:
      if (same && now.slides) return stick(k, time, state);
      break;
    case EventSource::Kind::slip:
      if (same && !now.slides) {
        Vector3 reaction;
        ReactionsAt reactions(*this, time, read_only(state.view.position), read_only(state.view.velocity));
        if (const springnet_status status = reactions.of(k, reaction); status != SPRINGNET_OK) return status;
        slip(k, reaction, time, state);
      }
      break;
    case EventSource::Kind::rupture:
    case EventSource::Kind::element_rupture:
      break;
  }
  return SPRINGNET_OK;
}

springnet_status Engine::fire_events(double time, State& state, const std::int32_t* fired) {
  set_time(time);
  const std::vector<EventSource> sources = event_sources();
  std::vector<std::uint32_t> broken, broken_elements, touched;
  for (std::size_t e = 0; e < sources.size(); ++e) {
    const EventSource& source = sources[e];
    const std::uint32_t k = source.index;
    bool now = fired[e] != 0;
    if (source.kind == EventSource::Kind::touch && !now) {
      const Vector3 p = vector_at(state.view.position, k);
      now = contact_.distance(source.surface, p) <= touch_depth_ &&
            contact_.normal(source.surface, p)
                    .dot(vector_at(state.view.velocity, k) - contact_.placement(source.surface).velocity) <
                -rounding_of_speed * info_.velocity_scale;
    }
    if (!now) continue;
    if (source.kind == EventSource::Kind::rupture)
      broken.push_back(k);
    else if (source.kind == EventSource::Kind::element_rupture)
      broken_elements.push_back(k);
    else if (const springnet_status status = fire(source, time, state, touched); status != SPRINGNET_OK)
      return status;
  }
  if (!broken.empty() || !broken_elements.empty()) remove(broken, broken_elements, {}, Event::Kind::ruptured, time);
  // What was stopped stops, with its share, what hangs rigidly on it.
  if (rigid_.any() && !touched.empty()) {
    const springnet_status status = rigid_.project(state.view.position, state.view.velocity, message_, touched);
    if (status != SPRINGNET_OK) return status;
  }
  // A node that is pulled away where it touches does not stay.
  ReactionsAt reactions(*this, time, read_only(state.view.position), read_only(state.view.velocity));
  std::vector<std::pair<std::uint32_t, std::size_t>> lifted;
  std::sort(touched.begin(), touched.end());
  touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  for (const std::uint32_t k : touched) {
    const Touch touch = contact_.committed(k);
    if (touch.surface < 0) continue;
    Vector3 reaction;
    const springnet_status status = reactions.of(k, reaction);
    if (status != SPRINGNET_OK) return status;
    for (const std::int32_t surface : {touch.surface, touch.second}) {
      const auto j = static_cast<std::size_t>(surface);
      if (surface < 0 || pressing_of(k, j, vector_at(state.view.position, k), reaction) >= 0.0) continue;
      lifted.emplace_back(k, j);
      break;
    }
  }
  for (const auto& [node, surface] : lifted) {
    if (contact_.committed(node).second >= 0)
      let_go_of_one(node, surface, time);
    else
      let_go(node, time);
  }
  if (!touched.empty())
    if (const springnet_status status = release_grip(time, state); status != SPRINGNET_OK) return status;
  return evaluator_.evaluate(time, state.nodes(), external_at(time), state.forces(), {}, message_);
}

springnet_status Engine::stop_penetration(double time, State& state) {
  std::vector<std::uint32_t> stopped;
  std::optional<ReactionsAt> at;
  for (std::size_t j = 0; j < contact_.surfaces().size(); ++j) {
    for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
      if (contact_.constrained()[k] != 0 || contact_.committed(k).surface == static_cast<std::int32_t>(j)) continue;
      if (contact_.distance(j, vector_at(state.view.position, k)) >= -penetration * info_.length_scale) continue;
      if (!at) at.emplace(*this, time, read_only(state.view.position), read_only(state.view.velocity));
      Departure departs;
      if (const springnet_status status = departure(*at, k, j, state, departs); status != SPRINGNET_OK) return status;
      const bool is_shallow = contact_.distance(j, vector_at(state.view.position, k)) > -shallow * info_.length_scale;
      if (is_shallow && contact_.committed(k).surface < 0 && turns_round(departs)) continue;
      touch(k, j, time, state);
      stopped.push_back(k);
      if (rigid_.any()) at.reset();
    }
  }
  return stopped.empty() || !rigid_.any() ? SPRINGNET_OK
                                          : rigid_.project(state.view.position, state.view.velocity, message_, stopped);
}

}  // namespace springnet
