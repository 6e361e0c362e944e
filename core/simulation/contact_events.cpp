#include "simulation/contact_events.hpp"

#include <algorithm>
#include <cmath>

#include "constraints/vectors.hpp"
#include "simulation/contact_notes.hpp"
#include "simulation/settling.hpp"

namespace springnet {
const std::vector<ContactEvents::Source>& ContactEvents::sources() {
  if (sources_revision_ == model_.revision) return sources_;
  sources_.clear();
  AtCommitted at(model_);
  if (!model_.contact.obstacles().empty()) {
    const double tolerance = model_.contact_tolerance();
    const std::shared_ptr<const Placement> now = model_.placement_now();
    for (std::uint32_t k = 0; k < model_.node_count(); ++k)
      if (model_.contact.fixed()[k] == 0) add_sources_of(k, tolerance, *now, at);
  }
  pair_depths_.clear();
  if (model_.constraints.bodies().located()) add_sources_of_pairs(at);
  sources_revision_ = model_.revision;
  return sources_;
}

void ContactEvents::add_sources_of(std::uint32_t k, double tolerance, const Placement& now, AtCommitted& at) {
  const Contact& contact = model_.contact;
  const Touch touch = contact.committed(k);
  bool has_friction = false;
  for (const std::int32_t j : touch.surfaces()) {
    if (j < 0) continue;
    sources_.push_back({Kind::release, k, static_cast<std::uint32_t>(j), -on_cones()});
    if (contact.braced(k))
      sources_.back().offset = beyond_brace(sources_.back(), at);
    else if (is_pushed_cluster(k))
      sources_.back().offset += beyond_release(sources_.back(), at);
    if (touch.slides && !contact.obstacles()[static_cast<std::size_t>(j)].is_plane())
      sources_.push_back({Kind::seam, k, static_cast<std::uint32_t>(j)});
    const double mu = model_.constraints.coefficient(k, static_cast<std::size_t>(j));
    // Friction without a limit does not slip.
    has_friction = has_friction || (touch.slides ? mu > 0.0 : mu > 0.0 && std::isfinite(mu));
  }
  if (has_friction && touch.third < 0) {
    const auto j = static_cast<std::uint32_t>(touch.surface);
    if (!touch.slides) {
      sources_.push_back({Kind::slip, k, j});
      sources_.back().offset = on_cones() + beyond_cone(sources_.back(), at);
    } else {
      const Contact::Slip phase = contact.slip_phase(k);
      sources_.push_back({Kind::rest, k, j});  // steps may go past the end of a slip
      sources_.push_back({phase == Contact::Slip::ongoing ? Kind::slow : Kind::quick, k, j});
      if (phase == Contact::Slip::starting) sources_.push_back({Kind::stall, k, j});
    }
  }
  // A sticking node reaches only obstacles that move, unless its own obstacle carries it.
  const bool sticks = touch.surface >= 0 && !touch.slides;
  const bool carried = sticks && contact.obstacles()[static_cast<std::size_t>(touch.surface)].moves();
  for (std::size_t j = 0; j < contact.obstacles().size(); ++j) {
    if (touch.has(static_cast<std::int32_t>(j)) || (sticks && !carried && !contact.obstacles()[j].moves())) continue;
    // From the contact tolerance on: a node that lies on the surface, up to rounding, has a value above 0 that falls
    // through it when the node sinks in. A node that was released a little behind the surface as well; its touch counts
    // from several times as deep, because each time it is found again costs a restart.
    const double behind = -contact.gap(now, j, vector_at(model_.state.view.position, k));
    sources_.push_back({Kind::touch, k, static_cast<std::uint32_t>(j), tolerance + 4.0 * std::max(0.0, behind)});
  }
}

bool ContactEvents::is_pushed_cluster(std::uint32_t node) const {
  const BodyContacts& bodies = model_.constraints.bodies();
  return model_.rigid.is_joined(node) && bodies.located() && !bodies.touching().empty();
}

springnet_status ContactEvents::separating_acceleration(const Source& source, const ReactionsAt& at,
                                                        double& value) const {
  const std::uint32_t k = source.index;
  ReactionsAt without(at);
  without.leave_out(k);
  Vector3 a;
  const springnet_status status = without.acceleration(k, a);
  const Placement& placement = at.placement();
  const Vector3 p = at.position(k);
  value =
      model_.contact.normal(placement, source.surface, p).dot(a - Contact::acceleration(placement, source.surface, p));
  return status;
}

// A force already beyond the friction cone by rounding would never be seen to cross it: with this offset the node slips
// once the force is twice as far beyond.
double ContactEvents::beyond_cone(const Source& source, AtCommitted& at) const {
  if (model_.step_length > 0.0) return 0.0;  // only methods that choose their own steps need it
  double margin = 0.0;
  if (this->value(source, at(), margin) != SPRINGNET_OK || margin > 0.0) return 0.0;
  return -2.0 * margin + rounding_of_force * model_.scales.force;
}

// Friction that is held to end a flutter slips once it is clearly beyond its limit.
double ContactEvents::beyond_held(const Source& source, AtCommitted& at) const {
  constexpr double clearly = 1e-3;  // of the limit
  const BodyContacts& bodies = model_.constraints.bodies();
  const PairTouch& touch = bodies.touching()[static_cast<std::size_t>(source.pair)];
  const BodyMotion* all = nullptr;
  if (!touch.held || at().bodies(all) != SPRINGNET_OK || all == nullptr) return 0.0;
  return clearly * coefficient_of(bodies.law_of(touch.kind, touch.pair).friction) *
         std::abs(all->pairs()[static_cast<std::size_t>(source.pair)].pressing);
}

// A node braced with others stays in contact although it would separate if it alone were released. With this offset it
// is released once it would separate twice as fast.
double ContactEvents::beyond_brace(const Source& source, AtCommitted& at) const {
  if (model_.step_length > 0.0) return 0.0;  // only methods that choose their own steps need it
  double separating = 0.0;
  if (this->value(source, at(), separating) != SPRINGNET_OK || separating < 0.0) return 0.0;
  return -2.0 * separating - rounding_of_force * model_.scales.force / model_.mass[source.index];
}

springnet_status ContactEvents::value(const Source& source, ReactionsAt& reactions, double& value) const {
  if (source.pair >= 0) return pair_value(source, reactions, value);
  const Contact& contact = model_.contact;
  const std::uint32_t k = source.index;
  const Placement& at = reactions.placement();
  const Vector3 p = reactions.position(k);
  switch (source.kind) {
    case Kind::touch:
      value = contact.gap(at, source.surface, p) + source.offset;  // 0 would not count as a crossing
      return SPRINGNET_OK;
    case Kind::seam: {
      const double to = contact.obstacles()[source.surface].seam(at.poses[source.surface], p);
      value = std::isfinite(to) ? to : model_.scales.length;
      return SPRINGNET_OK;
    }
    case Kind::rest:
      value = contact.slip(k).dot(contact.slip_vector(at, k, source.surface, p, reactions.velocity(k)));
      // A slip that begins goes its way as long as it is accelerated, whatever errors of integration make of it.
      if (contact.slip_phase(k) == Contact::Slip::starting) value += quick_slip * contact.rest_speed();
      return SPRINGNET_OK;
    case Kind::quick:
      value = contact.slip_vector(at, k, source.surface, p, reactions.velocity(k)).norm() -
              quick_slip * contact.rest_speed();
      return SPRINGNET_OK;
    case Kind::stall: {
      Vector3 a;
      if (const springnet_status status = reactions.constrained(k, a); status != SPRINGNET_OK) return status;
      value = contact.slip_direction(at, k, source.surface, p, reactions.velocity(k))
                  .dot(a - Contact::acceleration(at, source.surface, p)) +
              Scales::min_force * model_.scales.force / model_.mass[k];  // a is 0 if rods to sticking nodes hold it
      return SPRINGNET_OK;
    }
    case Kind::slow:
      value = contact.slip_vector(at, k, source.surface, p, reactions.velocity(k)).norm() - contact.rest_speed();
      return SPRINGNET_OK;
    default:
      break;
  }
  if (source.kind == Kind::release && contact.braced(k)) {
    const springnet_status status = separating_acceleration(source, reactions, value);
    value += source.offset;
    return status;
  }
  // Bracing has decided that the node sticks; its event function is that of the unbraced reaction.
  Vector3 reaction;
  const springnet_status status =
      source.kind == Kind::release ? reactions.unbraced(k, reaction) : reactions.of(k, reaction);
  if (status != SPRINGNET_OK) return status;
  const Touch& touch = contact.committed(k);
  const SplitReaction split = split_reaction(contact.normals(at, k, p), reaction);
  double limit = 0.0;
  for (std::size_t i = 0; i < split.normal.size(); ++i) {
    const auto j = static_cast<std::size_t>(touch.surfaces()[i]);
    if (j == source.surface) value = -split.normal[i];
    limit += friction_limit(model_.constraints.coefficient(k, j), split.normal[i]);
  }
  if (source.kind == Kind::slip) value = limit - split.tangential.norm();
  value += source.offset;
  return SPRINGNET_OK;
}

springnet_status ContactEvents::values(const springnet_evaluation& request, double* values, std::int32_t* directions) {
  const std::vector<Source>& all = sources();
  const layers::InternalView internal = model_.internal_for(request.internal);
  const Loads::Instant loads(model_.loads, request.time);
  ReactionsAt reactions(model_, request.time, request.position, request.velocity, internal);
  for (std::size_t e = 0; e < all.size(); ++e) {
    const Source& source = all[e];
    if (directions != nullptr)
      directions[e] = source.kind == Kind::seam && source.pair < 0                 ? 0
                      : source.kind == Kind::release || source.kind == Kind::quick ? 1
                                                                                   : -1;
    if (const springnet_status status = value(source, reactions, values[e]); status != SPRINGNET_OK) return status;
  }
  const std::size_t breaking = topology_.rupturing().count();
  if (breaking == 0) return SPRINGNET_OK;
  if (directions != nullptr) std::fill_n(directions + all.size(), breaking, -1);
  return topology_.margins(request.time, node_arrays(request.position, request.velocity, internal),
                           values + all.size());
}

void ContactEvents::names(std::uint32_t* kinds, std::uint32_t* who, std::uint32_t* surfaces) {
  constexpr std::uint32_t none = 0xffffffffu;
  std::size_t place = 0;
  const auto put = [&](std::uint32_t kind, std::uint32_t whose, std::uint32_t surface) {
    if (kinds != nullptr) kinds[place] = kind;
    if (who != nullptr) who[place] = whose;
    if (surfaces != nullptr) surfaces[place] = surface;
    ++place;
  };
  const auto kind_of = [](Kind kind) -> std::uint32_t {
    switch (kind) {
      case Kind::touch:
        return SPRINGNET_EVENT_TOUCH;
      case Kind::release:
        return SPRINGNET_EVENT_RELEASE;
      case Kind::slip:
        return SPRINGNET_EVENT_SLIP;
      case Kind::rest:
        return SPRINGNET_EVENT_REST;
      case Kind::seam:
        return SPRINGNET_EVENT_SEAM;
      default:
        return SPRINGNET_EVENT_SLIP_CHANGE;
    }
  };
  for (const Source& source : sources()) put(kind_of(source.kind), source.index, source.surface);
  const Topology::Rupturing& breaking = topology_.rupturing();
  for (const std::uint32_t spring : breaking.springs) put(SPRINGNET_EVENT_SPRING_RUPTURE, spring, none);
  for (const std::uint32_t element : breaking.elements) put(SPRINGNET_EVENT_ELEMENT_RUPTURE, element, none);
}

bool ContactEvents::is_impacting(const Source& source, const Placement& at, const State& state,
                                 double tolerance) const {
  const Vector3 p = vector_at(state.view.position, source.index);
  return model_.contact.gap(at, source.surface, p) <= tolerance &&
         model_.contact.normal(at, source.surface, p)
                 .dot(vector_at(state.view.velocity, source.index) - Contact::velocity(at, source.surface, p)) <
             -model_.no_speed();
}

springnet_status ContactEvents::fire(double time, State& state, const std::int32_t* fired) {
  const std::shared_ptr<const Placement> at = model_.placement(time);
  const std::vector<Source> all = this->sources();  // they change below
  // Place sticking nodes exactly: integration errors must not decide whether and where they slip.
  model_.constraints.place(*at, read_only(model_.state.view.position), state.view.position, state.view.velocity);
  model_.constraints.project_pairs(*at, state.view.position, state.view.velocity);
  std::vector<std::uint32_t> broken, broken_elements;
  const Topology::Rupturing& breaking = topology_.rupturing();
  const std::int32_t* const springs_fired = fired + all.size();
  const std::int32_t* const elements_fired = springs_fired + breaking.springs.size();
  for (std::size_t i = 0; i < breaking.springs.size(); ++i)
    if (springs_fired[i] != 0) broken.push_back(breaking.springs[i]);
  for (std::size_t i = 0; i < breaking.elements.size(); ++i)
    if (elements_fired[i] != 0) broken_elements.push_back(breaking.elements[i]);
  Findings findings;
  const double tolerance = model_.contact.obstacles().empty() ? 0.0 : model_.contact_tolerance();
  const auto slip_of = [&](const Source& source) {
    return model_.contact.slip_vector(*at, source.index, source.surface, vector_at(state.view.position, source.index),
                                      vector_at(state.view.velocity, source.index));
  };
  for (std::size_t e = 0; e < all.size(); ++e) {
    const Source& source = all[e];
    const std::uint32_t k = source.index;
    if (fired[e] == 0 && !(source.kind == Kind::touch && is_impacting(source, *at, state, tolerance))) continue;
    if (source.pair >= 0) {
      find_pair(source, time, state, findings);
      continue;
    }
    switch (source.kind) {
      case Kind::slow:
        Settling(model_, time, state, findings).keep_direction(k);
        model_.changed();
        break;
      case Kind::quick: {
        const Vector3 slip = slip_of(source);
        if (model_.contact.slip_phase(k) == Contact::Slip::ending) note_grazing_slip(model_, k, source.surface, time);
        model_.contact.set_slip(k, slip.normalized());
        model_.changed();
        break;
      }
      case Kind::stall: {
        const Vector3 slip = slip_of(source);
        note_grazing_slip(model_, k, source.surface, time);
        if (model_.contact.slip(k).dot(slip) > model_.no_speed())
          Settling(model_, time, state, findings).keep_direction(k);
        else
          findings.nodes[k].slip_ended = true;
        model_.changed();
        break;
      }
      case Kind::seam:
        findings.nodes[k];
        model_.changed();  // the reaction jumps
        break;
      case Kind::touch:
        findings.nodes[k].touched.push_back(static_cast<std::int32_t>(source.surface));
        model_.changed();  // the offset of a separating node's touch follows its position
        break;
      case Kind::release:
        findings.nodes[k].released.push_back(static_cast<std::int32_t>(source.surface));
        if (is_pushed_cluster(k)) model_.changed();  // the offset follows the forces
        break;
      case Kind::slip:
        findings.nodes[k].slips = true;
        break;
      case Kind::rest: {
        const Vector3 slip = slip_of(source);
        // A slip that turned by a right angle continues. One that reversed, because a step went past its end, has come
        // to rest.
        const double rest = model_.contact.rest_speed();
        if (slip.norm() > rest && std::abs(model_.contact.slip(k).dot(slip)) <= rest) {
          model_.contact.set_slip(k, slip.normalized());
          model_.changed();
        } else {
          findings.nodes[k].slip_ended = true;
        }
        break;
      }
    }
  }
  if (model_.constraints.bodies().located()) find_impacts(state, findings);
  if (!broken.empty() || !broken_elements.empty())
    topology_.remove({broken, broken_elements, {}}, Event::Kind::ruptured, time, state.nodes());
  {
    const Loads::Instant loads(model_.loads, time);
    if (const springnet_status status = settle(model_, time, state, findings); status != SPRINGNET_OK) return status;
  }
  return model_.evaluator.evaluate(time, state.nodes(), model_.external_at(time), state.forces(), {},
                                   model_.journal.message);
}

}  // namespace springnet
