// Contacts made, released, slipping and sticking, as an integrator with events sees them.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "constraints/vectors.hpp"
#include "layers/springs/queries.hpp"
#include "plugin_host/message.hpp"
#include "simulation/engine.hpp"
#include "simulation/reactions_at.hpp"
#include "simulation/settling.hpp"

namespace springnet {
namespace {

// A node this far behind a surface was not seen to cross it, in units of the length scale: twice within one step of
// the reference, say.
constexpr double penetration = 1e-9;
// A node that a surface stopped has no speed against it but rounding, in units of the velocity scale.
// A node this far behind a surface that it touches has no place left; likewise.
constexpr double squeezed = 1e-7;
constexpr double rounding_of_speed = 1e-13;
constexpr double rounding_of_force = 1e-14;  // likewise
constexpr double least_force = 1e-9;         // likewise, of what is decided by forces
// Slip that is so much faster than the speed of rest has a direction that friction follows.
constexpr double quick_slip = 4.0;

}  // namespace

double Engine::no_speed() const noexcept { return rounding_of_speed * info_.velocity_scale; }

const std::vector<Engine::EventSource>& Engine::event_sources() {
  if (sources_revision_ == revision_) return sources_;
  using Kind = EventSource::Kind;
  sources_.clear();
  const auto surfaces = static_cast<std::int32_t>(contact_.surfaces().size());
  const double depth = surfaces > 0 ? contact_tolerance() : 0.0;
  const std::shared_ptr<const Placement> now = contact_.at(just_after(time_));
  for (std::uint32_t k = 0; surfaces > 0 && k < layout_.node_count(); ++k) {
    if (contact_.fixed()[k] != 0) continue;
    const Touch touch = contact_.committed(k);
    bool has_friction = false;
    for (const std::int32_t j : touch.surfaces()) {
      if (j < 0) continue;
      sources_.push_back({Kind::release, k, static_cast<std::uint32_t>(j)});
      if (contact_.braced(k)) sources_.back().depth = beyond_brace(sources_.back());
      if (touch.slides && !contact_.surfaces()[static_cast<std::size_t>(j)].is_plane())
        sources_.push_back({Kind::seam, k, static_cast<std::uint32_t>(j)});
      const double mu = coefficient(k, static_cast<std::size_t>(j));
      // What holds without bounds does not slip.
      has_friction = has_friction || (touch.slides ? mu > 0.0 : mu > 0.0 && std::isfinite(mu));
    }
    if (has_friction && touch.third < 0) {
      const auto j = static_cast<std::uint32_t>(touch.surface);
      if (!touch.slides) {
        sources_.push_back({Kind::slip, k, j});
        sources_.back().depth = beyond_cone(sources_.back());
      } else {
        const Contact::Slip phase = contact_.slip_phase(k);
        sources_.push_back({Kind::rest, k, j});  // steps may go past the end of a slip
        sources_.push_back({phase == Contact::Slip::goes_on ? Kind::slow : Kind::quick, k, j});
        if (phase == Contact::Slip::begins) sources_.push_back({Kind::stall, k, j});
      }
    }
    // What sticks reaches only what moves there, or is carried there itself.
    const bool sticks = touch.surface >= 0 && !touch.slides;
    const bool carried = sticks && contact_.surfaces()[static_cast<std::size_t>(touch.surface)].moves();
    for (std::int32_t j = 0; j < surfaces; ++j) {
      if (touch.has(j) || (sticks && !carried && !contact_.surfaces()[static_cast<std::size_t>(j)].moves())) continue;
      // From the contact tolerance on: a node that lies on the surface, up to rounding, has a value above 0 that falls
      // through it when the node sinks in. One that was let go a little behind it too, and is watched for from several
      // times as deep, because each time it is found again costs a restart.
      const auto surface = static_cast<std::size_t>(j);
      const double behind = -contact_.gap(*now, surface, vector_at(state_.view.position, k));
      sources_.push_back({Kind::touch, k, static_cast<std::uint32_t>(j), depth + 4.0 * std::max(0.0, behind)});
    }
  }
  for (const std::uint32_t s : rupturing().springs) sources_.push_back({Kind::rupture, s, 0});
  for (const std::uint32_t e : rupturing().elements) sources_.push_back({Kind::element_rupture, e, 0});
  sources_revision_ = revision_;
  return sources_;
}

// A node that is braced leaves when its gap would open if its surface did not hold it, m/s^2.
springnet_status Engine::acceleration_let_go(const EventSource& source, const ReactionsAt& at, double& value) const {
  const std::uint32_t k = source.index;
  ReactionsAt without(at);
  without.leave_out(k);
  Vector3 a;
  const springnet_status status = without.acceleration(k, a);
  const Placement& placement = at.placement();
  const Vector3 p = at.position(k);
  value = contact_.normal(placement, source.surface, p).dot(a - Contact::acceleration(placement, source.surface, p));
  return status;
}

// A node that rests beyond the cone of friction by rounding would not be seen to cross it: twice as far from there on.
double Engine::beyond_cone(const EventSource& source) {
  if (step_length_ > 0.0) return 0.0;  // nobody asks
  ReactionsAt reactions(*this, time_, read_only(state_.view.position), read_only(state_.view.velocity));
  double grip = 0.0;
  if (contact_event(source, reactions, grip) != SPRINGNET_OK || grip > 0.0) return 0.0;
  return -2.0 * grip + rounding_of_force * info_.force_scale;
}

// What was braced with others stays, though it would leave if it alone was let go: until it would twice as fast.
double Engine::beyond_brace(const EventSource& source) {
  if (step_length_ > 0.0) return 0.0;  // nobody asks
  ReactionsAt reactions(*this, time_, read_only(state_.view.position), read_only(state_.view.velocity));
  double leaves = 0.0;
  if (contact_event(source, reactions, leaves) != SPRINGNET_OK || leaves < 0.0) return 0.0;
  return -2.0 * leaves - rounding_of_force * info_.force_scale / mass_[source.index];
}

// Of friction of a node on a surface, infinite where that holds it.
double Engine::coefficient(std::uint32_t node, std::size_t surface) const {
  const std::uint32_t* clusters = rigid_.cluster_of();
  const Friction& friction = contact_.surfaces()[surface].friction();
  return coefficient_of(clusters != nullptr && clusters[node] != ConstraintRow::no_node ? bounded(friction) : friction);
}

// The value of an event of a contact.
springnet_status Engine::contact_event(const EventSource& source, ReactionsAt& reactions, double& value) {
  using Kind = EventSource::Kind;
  const std::uint32_t k = source.index;
  const Placement& at = reactions.placement();
  const Vector3 p = reactions.position(k);
  switch (source.kind) {
    case Kind::touch:
      value = contact_.gap(at, source.surface, p) + source.depth;  // 0 would not count as a crossing
      return SPRINGNET_OK;
    case Kind::seam: {
      const double to = contact_.surfaces()[source.surface].seam(at.poses[source.surface], p);
      value = std::isfinite(to) ? to : info_.length_scale;
      return SPRINGNET_OK;
    }
    case Kind::rest:
      value = contact_.slip(k).dot(contact_.slip_vector(at, k, source.surface, p, reactions.velocity(k)));
      // A slip that begins goes its way as long as it is accelerated, whatever errors of integration make of it.
      if (contact_.slip_phase(k) == Contact::Slip::begins) value += quick_slip * contact_.rest_speed();
      return SPRINGNET_OK;
    case Kind::quick:
      value = contact_.slip_vector(at, k, source.surface, p, reactions.velocity(k)).norm() -
              quick_slip * contact_.rest_speed();
      return SPRINGNET_OK;
    case Kind::stall: {
      Vector3 a;
      if (const springnet_status status = reactions.bound(k, a); status != SPRINGNET_OK) return status;
      value = contact_.slip_direction(at, k, source.surface, p, reactions.velocity(k))
                  .dot(a - Contact::acceleration(at, source.surface, p)) +
              least_force * info_.force_scale / mass_[k];  // none, where connections to nodes that stick hold it
      return SPRINGNET_OK;
    }
    case Kind::slow:
      value = contact_.slip_vector(at, k, source.surface, p, reactions.velocity(k)).norm() - contact_.rest_speed();
      return SPRINGNET_OK;
    default:
      break;
  }
  if (source.kind == Kind::release && contact_.braced(k)) {
    const springnet_status status = acceleration_let_go(source, reactions, value);
    value += source.depth;
    return status;
  }
  // Whether a node that only bracing would press stays is decided when that begins.
  Vector3 reaction;
  const springnet_status status =
      source.kind == Kind::release ? reactions.unbraced(k, reaction) : reactions.of(k, reaction);
  if (status != SPRINGNET_OK) return status;
  const Touch& touch = contact_.committed(k);
  const SplitReaction split = split_reaction(contact_.normals(at, k, p), reaction);
  double bears = 0.0;
  for (std::size_t i = 0; i < split.normal.size(); ++i) {
    const auto j = static_cast<std::size_t>(touch.surfaces()[i]);
    if (j == source.surface) value = -split.normal[i];
    bears += bearing(coefficient(k, j), split.normal[i]);
  }
  if (source.kind == Kind::slip) value = bears - split.along.norm() + source.depth;
  return SPRINGNET_OK;
}

springnet_status Engine::event_values(const springnet_evaluation& request, double* values, std::int32_t* directions) {
  using Kind = EventSource::Kind;
  const std::vector<EventSource>& sources = event_sources();
  ReactionsAt reactions(*this, request.time, request.position, request.velocity);
  for (std::size_t e = 0; e < sources.size(); ++e) {
    const EventSource& source = sources[e];
    if (directions != nullptr)
      directions[e] = source.kind == Kind::seam                                    ? 0
                      : source.kind == Kind::release || source.kind == Kind::quick ? 1
                                                                                   : -1;
    if (source.kind == Kind::rupture || source.kind == Kind::element_rupture) continue;
    if (const springnet_status status = contact_event(source, reactions, values[e]); status != SPRINGNET_OK)
      return status;
  }
  const std::size_t breaking = rupturing().count();
  return breaking == 0 ? SPRINGNET_OK
                       : rupture_margins(request.time, node_arrays(request.position, request.velocity),
                                         values + (sources.size() - breaking));
}

// Touches that are about to happen within the tolerance count beside those that were found.
bool Engine::touches_now(const EventSource& source, const Placement& at, const State& state, double depth) const {
  const Vector3 p = vector_at(state.view.position, source.index);
  return contact_.gap(at, source.surface, p) <= depth &&
         contact_.normal(at, source.surface, p)
                 .dot(vector_at(state.view.velocity, source.index) - Contact::velocity(at, source.surface, p)) <
             -no_speed();
}

springnet_status Engine::fire_events(double time, State& state, const std::int32_t* fired) {
  using Kind = EventSource::Kind;
  const std::shared_ptr<const Placement> at = placement(time);
  const std::vector<EventSource> sources = event_sources();
  // What integration made of nodes that stick: whether and where they slip is decided from the motion of their surface.
  constraints_.place(*at, read_only(state_.view.position), state.view.position, state.view.velocity);
  std::vector<std::uint32_t> broken, broken_elements;
  Settling::Findings findings;
  const double depth = contact_.surfaces().empty() ? 0.0 : contact_tolerance();
  for (std::size_t e = 0; e < sources.size(); ++e) {
    const EventSource& source = sources[e];
    const std::uint32_t k = source.index;
    if (fired[e] == 0 && !(source.kind == Kind::touch && touches_now(source, *at, state, depth))) continue;
    switch (source.kind) {
      case Kind::rupture:
        broken.push_back(k);
        break;
      case Kind::element_rupture:
        broken_elements.push_back(k);
        break;
      case Kind::slow:
        Settling(*this, time, state, findings).keep_direction(k);
        changed();
        break;
      case Kind::quick: {
        const Vector3 slip = contact_.slip_vector(*at, k, source.surface, vector_at(state.view.position, k),
                                                  vector_at(state.view.velocity, k));
        if (contact_.slip_phase(k) == Contact::Slip::ends) note_grazing_slip(k, source.surface, time);
        contact_.set_slip(k, slip.normalized());
        changed();
        break;
      }
      case Kind::stall: {
        const Vector3 slip = contact_.slip_vector(*at, k, source.surface, vector_at(state.view.position, k),
                                                  vector_at(state.view.velocity, k));
        note_grazing_slip(k, source.surface, time);
        if (contact_.slip(k).dot(slip) > no_speed())
          Settling(*this, time, state, findings).keep_direction(k);
        else
          findings[k].rests = true;
        changed();
        break;
      }
      case Kind::seam:
        findings[k];
        changed();  // the reaction jumps
        break;
      case Kind::touch:
        findings[k].touched.push_back(static_cast<std::int32_t>(source.surface));
        changed();  // one that moves off already is watched for from where it is
        break;
      case Kind::release:
        findings[k].released.push_back(static_cast<std::int32_t>(source.surface));
        break;
      case Kind::slip:
        findings[k].slips = true;
        break;
      case Kind::rest: {
        const Vector3 slip = contact_.slip_vector(*at, k, source.surface, vector_at(state.view.position, k),
                                                  vector_at(state.view.velocity, k));
        // A slip that turned by a right angle goes on; one that was turned round by a step that went past its end
        // rests.
        const double rest = contact_.rest_speed();
        if (slip.norm() > rest && std::abs(contact_.slip(k).dot(slip)) <= rest) {
          contact_.set_slip(k, slip.normalized());
          changed();
        } else {
          findings[k].rests = true;
        }
        break;
      }
    }
  }
  if (!broken.empty() || !broken_elements.empty()) remove(broken, broken_elements, {}, Event::Kind::ruptured, time);
  if (const springnet_status status = settle(time, state, findings); status != SPRINGNET_OK) return status;
  return evaluator_.evaluate(time, state.nodes(), external_at(time), state.forces(), {}, message_);
}

springnet_status Engine::settle(double time, State& state, const Settling::Findings& findings) {
  Settling settling(*this, time, state, findings);
  for (const auto& [node, finding] : findings)
    if (const springnet_status status = settling.settle(node); status != SPRINGNET_OK) return status;
  return settling.finish();
}

// Nodes that touch, or lie on a surface and may be pushed into it.
springnet_status Engine::settle_contacts(double time, State& state) {
  if (contact_.surfaces().empty()) return SPRINGNET_OK;
  const std::shared_ptr<const Placement> at = placement(time);
  const double depth = contact_tolerance();
  Settling::Findings findings;
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    if (contact_.fixed()[k] != 0) continue;
    bool near = contact_.committed(k).surface >= 0;
    for (std::size_t j = 0; j < contact_.surfaces().size() && !near; ++j)
      near = contact_.gap(*at, j, vector_at(state.view.position, k)) <= depth;
    if (near) findings[k];
  }
  return settle(time, state, findings);
}

springnet_status Engine::stop_penetration(double time, State& state) {
  const std::shared_ptr<const Placement> at = placement(time);
  Settling::Findings findings;
  for (std::size_t j = 0; j < contact_.surfaces().size(); ++j) {
    const auto surface = static_cast<std::int32_t>(j);
    for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
      if (contact_.constrained()[k] != 0 || contact_.committed(k).has(surface)) continue;
      if (contact_.gap(*at, j, vector_at(state.view.position, k)) >= -penetration * info_.length_scale) continue;
      findings[k].touched.push_back(surface);
    }
  }
  return settle(time, state, findings);
}

springnet_status Engine::follow_jumps(double from) {
  const std::set<std::uint32_t> pulled = follow_prescribed();
  if (contact_.surfaces().empty()) return SPRINGNET_OK;
  const std::shared_ptr<const Placement> before = contact_.at(just_before(time_, time_ - from));
  const std::shared_ptr<const Placement> now = contact_.at(just_after(time_));
  Settling::Findings findings;
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    const Vector3 p = vector_at(state_.view.position, k);
    bool jumps = false;
    for (const std::int32_t surface : contact_.committed(k).surfaces()) {
      if (surface < 0) continue;
      const auto j = static_cast<std::size_t>(surface);
      jumps = jumps || Contact::velocity(*before, j, p) != Contact::velocity(*now, j, p);
    }
    if (jumps) findings[k];
  }
  for (const std::uint32_t cluster : pulled)
    for (const std::uint32_t k : rigid_.nodes_of(cluster))
      if (contact_.touching()[k] != 0) findings[k];
  return settle(time_, state_, findings);
}

void Engine::note_shed(double from) {
  for (std::size_t e = committed_events_; e < events_.size(); ++e) {
    const Event& event = events_[e];
    if (event.kind != Event::Kind::released || event.surface < 0) continue;
    const auto j = static_cast<std::size_t>(event.surface);
    const Obstacle& surface = contact_.surfaces()[j];
    if (!surface.looks_sampled() || surface.next_change(from) > time_ || !shedding_.insert(j).second) continue;
    note(
        fmt::format("At {:g} s {} leaves node {} behind, first of those that it sheds, because the velocity of its "
                    "linear table jumps there. Set interpolation = \"smooth\" if the table was sampled from a smooth "
                    "motion.",
                    time_, contact_.name_of(j), event.index));
  }
}

// What surfaces that move leave of a node's place is none of the integrator's doing: no step and no force can mend it.
springnet_status Engine::check_room(double time, const State& state) {
  const std::vector<Obstacle>& surfaces = contact_.surfaces();
  if (std::none_of(surfaces.begin(), surfaces.end(), [](const Obstacle& surface) { return surface.moves(); }))
    return SPRINGNET_OK;
  const std::shared_ptr<const Placement> at = placement(time);
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    const Touch& touch = contact_.now(k);
    if (contact_.fixed()[k] != 0 || touch.surface < 0) continue;
    const Vector3 p = vector_at(state.view.position, k);
    bool behind = false;
    for (std::size_t j = 0; j < surfaces.size() && !behind; ++j) behind = contact_.gap(*at, j, p) < 0.0;
    if (!behind) continue;
    const std::vector<std::int32_t> closed = contact_.closed_around(*at, p, contact_tolerance());
    if (closed.empty()) continue;
    return no_place(k, closed, time);
  }
  return SPRINGNET_OK;
}

void Engine::note_grazing(std::uint32_t node, std::size_t surface, double time) {
  const std::uint32_t user = layout_.ordering().user[node];
  report("grazing_touches", ++grazing_touches_);
  if (grazing_touches_ > 1.0) return;
  note(
      fmt::format("At {:g} s node {} touches {} so slowly that errors of integration decide when, and whether; such "
                  "touches are counted as grazing_touches.",
                  time, user, contact_.name_of(surface)));
}

springnet_status Engine::no_place(std::uint32_t node, const std::vector<std::int32_t>& surfaces, double time) {
  const std::uint32_t* clusters = rigid_.cluster_of();
  const bool rods = clusters != nullptr && clusters[node] != ConstraintRow::no_node;
  set_message(message_,
              fmt::format("At {:.9g} s there is no place left for node {}{} between {}{}: they have closed; stop their "
                          "motion before, or let it get out of their way",
                          time, layout_.ordering().user[node], rods ? ", with what hangs rigidly on it," : "",
                          contact_.names_of(surfaces), surfaces.size() < 2 ? " and what else holds it" : ""));
  return SPRINGNET_RECOVERABLE;
}

springnet_status Engine::find_squeezed(double time, const State& state) {
  if (contact_.surfaces().empty()) return SPRINGNET_OK;
  const std::shared_ptr<const Placement> at = placement(time);
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    if (contact_.fixed()[k] != 0 || contact_.touching()[k] == 0) continue;
    double deepest = 0.0;
    std::vector<std::int32_t> surfaces;
    for (const std::int32_t surface : contact_.committed(k).surfaces()) {
      if (surface < 0) continue;
      const auto j = static_cast<std::size_t>(surface);
      surfaces.push_back(surface);
      deepest = std::max(deepest, -contact_.gap(*at, j, vector_at(state.view.position, k)));
    }
    if (deepest > squeezed * info_.length_scale) return no_place(k, surfaces, time);
  }
  return SPRINGNET_OK;
}

void Engine::note_unresolved(std::uint32_t node, double time) {
  const double before = statistics_.contains("unresolved_contacts") ? statistics_.at("unresolved_contacts") : 0.0;
  report("unresolved_contacts", before + 1.0);
  if (before > 0.0) return;
  note(fmt::format(
      "At {:g} s no forces of surfaces were found that fit node {} and what hangs rigidly on it: one of them "
      "may pull, or friction be more than it can; such moments are counted as unresolved_contacts.",
      time, layout_.ordering().user[node]));
}

void Engine::note_grazing_slip(std::uint32_t node, std::size_t surface, double time) {
  const double before = statistics_.contains("grazing_slips") ? statistics_.at("grazing_slips") : 0.0;
  report("grazing_slips", before + 1.0);
  if (before > 0.0) return;
  note(
      fmt::format("At {:g} s node {} slips on {} so slowly that errors of integration decide when that begins or ends, "
                  "and whether; such slips are counted as grazing_slips.",
                  time, layout_.ordering().user[node], contact_.name_of(surface)));
}

}  // namespace springnet
