// Event functions of pairs of bodies that touch: release, slip and its end.

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "constraints/friction.hpp"
#include "constraints/pair_features.hpp"
#include "simulation/body_groups.hpp"
#include "simulation/contact_events.hpp"
#include "simulation/pair_events.hpp"

namespace springnet {
namespace {

constexpr double times_overlap = 4.0;  // from which on a pair that overlaps a little touches again

}  // namespace

void ContactEvents::add_sources_of_pairs(AtCommitted& at) {
  const BodyContacts& bodies = model_.constraints.bodies();
  const double tolerance = pair_tolerance_ = model_.contact_tolerance();
  for (const proximity::NearPair& each : pairs_apart_within(model_, read_only(model_.state.view.position), 0.0))
    if (each.gap < 0.0) pair_depths_[{each.kind, each.pair}] = tolerance - times_overlap * each.gap;
  constexpr std::uint32_t no_surface = 0xffffffffu;
  find_redundant();
  for (std::size_t i = 0; i < bodies.touching().size(); ++i) {
    const PairTouch& touch = bodies.touching()[i];
    const std::uint32_t node = bodies.primitives().nodes_of(touch.kind, touch.pair)[0];
    const auto add = [&](Kind kind) {
      sources_.push_back({kind, node, no_surface, 0.0, static_cast<std::int32_t>(i)});
    };
    add(Kind::release);
    sources_.back().offset = beyond_release(sources_.back(), at) - on_cones();
    if (touch.kind != proximity::PairKind::node_node) {
      add(Kind::seam);
      sources_.back().offset = behind_border(sources_.back(), at);
    }
    const double mu = coefficient_of(bodies.law_of(touch.kind, touch.pair).friction);
    if (!(mu > 0.0) || (touch.sticks && !std::isfinite(mu))) continue;
    if (touch.sticks) {
      add(Kind::slip);
      sources_.back().offset = on_cones() + beyond_cone(sources_.back(), at) + beyond_held(sources_.back(), at);
      continue;
    }
    add(Kind::rest);
    add(touch.phase == Contact::Slip::ongoing ? Kind::slow : Kind::quick);
    if (touch.phase == Contact::Slip::starting) add(Kind::stall);
  }
}

double ContactEvents::before_redundant(std::int32_t place, const BodyMotion& all,
                                       const springnet_const_vectors& position) const {
  const BodyContacts& bodies = model_.constraints.bodies();
  const auto i = static_cast<std::size_t>(place);
  const PairTouch& touch = bodies.touching()[i];
  const double tolerance = 0.5 * pair_tolerance_;
  double result = 1.0;
  for (const std::size_t other : may_be_same_[i])
    result = std::min(result, before_same(all.pairs()[i].motion, all.pairs()[other].motion, same_gap()));
  if (touch.between == proximity::all_features(proximity::PairKind::edge_edge) && may_be_side_by_side_[i] != 0)
    result = std::min(
        result, before_side_by_side(
                    touch.kind,
                    bodies.primitives().corners(touch.kind, touch.pair, positions_of(position, model_.node_count())),
                    tolerance));
  return result;
}

// m: positions tell no smaller differences of gaps.
double ContactEvents::same_gap() const { return std::max(pair_tolerance_, model_.position_uncertainty); }

void ContactEvents::find_redundant() {
  const BodyContacts& bodies = model_.constraints.bodies();
  const std::vector<PairTouch>& touching = bodies.touching();
  const springnet_const_vectors position = read_only(model_.state.view.position),
                                velocity = read_only(model_.state.view.velocity);
  const double tolerance = 0.5 * pair_tolerance_;
  const auto is_inside = [](const PairTouch& each) { return each.between == proximity::all_features(each.kind); };
  std::vector<PairMotion> motions;
  std::map<std::uint32_t, std::vector<std::size_t>> at_nodes;
  may_be_same_.assign(touching.size(), {});
  may_be_side_by_side_.assign(touching.size(), 0);
  for (std::size_t i = 0; i < touching.size(); ++i) {
    const PairTouch& touch = touching[i];
    const PairMotion& motion =
        motions.emplace_back(pair_motion(bodies, touch, position, velocity, model_.node_count()));
    std::set<std::size_t> others;
    for (std::size_t j = 0; j < motion.count; ++j) {
      std::vector<std::size_t>& there = at_nodes[motion.nodes[j]];
      others.insert(there.begin(), there.end());
      there.push_back(i);
    }
    for (const std::size_t other : others)
      if (is_inside(touch) && is_inside(touching[other]) &&
          bodies.touch_alike(touch.kind, touch.pair, touching[other].kind, touching[other].pair) &&
          before_same(motion, motions[other], same_gap()) > 0.0)
        may_be_same_[i].push_back(other);
    const std::array<Vector3, 4> corners =
        bodies.primitives().corners(touch.kind, touch.pair, positions_of(position, model_.node_count()));
    may_be_side_by_side_[i] = before_side_by_side(touch.kind, corners, tolerance) > 0.0 ? 1 : 0;
  }
}

// Of faces on faces, and of the feet of a rigid body, forces may pull a little where no others fit; with this offset it
// is released once they pull twice as much.
double ContactEvents::beyond_release(const Source& source, AtCommitted& at) const {
  Source plain = source;
  plain.offset = 0.0;
  double pulling = 0.0;
  if (value(plain, at(), pulling) != SPRINGNET_OK || pulling < 0.0) return 0.0;
  return -2.0 * pulling - rounding_of_force * model_.scales.force;
}

double ContactEvents::behind_border(const Source& source, AtCommitted& at) const {
  double before = 0.0;
  if (value(source, at(), before) != SPRINGNET_OK || before > 0.0) return 0.0;
  return feature_border - before;
}

double ContactEvents::on_cones() const {
  const BodyContacts& bodies = model_.constraints.bodies();
  if (!bodies.located() || bodies.touching().empty()) return 0.0;
  return 2.0 * Scales::min_force * model_.scales.force;
}

springnet_status ContactEvents::pair_value(const Source& source, ReactionsAt& reactions, double& value) const {
  const BodyContacts& bodies = model_.constraints.bodies();
  const PairTouch& touch = bodies.touching()[static_cast<std::size_t>(source.pair)];
  const double rest = model_.contact.rest_speed();
  const BodyMotion* all = nullptr;
  if (const springnet_status status = reactions.bodies(all); status != SPRINGNET_OK) return status;
  if (all == nullptr) {
    value = 1.0;  // a step decides
    return SPRINGNET_OK;
  }
  const BodyMotion::OfPair& pair = all->pairs()[static_cast<std::size_t>(source.pair)];
  switch (source.kind) {
    case Kind::release:
      value = source.offset - pair.pressing;
      break;
    case Kind::seam:
      value = before_border(bodies, touch, pair.motion, positions_of(reactions.all_positions(), model_.node_count()),
                            pair_tolerance_) +
              source.offset;
      value = std::min(value, before_redundant(source.pair, *all, reactions.all_positions()));
      break;
    case Kind::slip:
      value = cone_margin(coefficient_of(bodies.law_of(touch.kind, touch.pair).friction), pair.pressing,
                          pair.motion.along(pair.force).norm()) +
              source.offset;
      break;
    case Kind::rest:
      value = touch.slip.dot(pair.motion.slip());
      if (touch.phase == Contact::Slip::starting) value += quick_slip * rest;
      break;
    case Kind::quick:
      value = pair.motion.slip().norm() - quick_slip * rest;
      break;
    case Kind::stall:
      value = slip_direction(model_, touch, pair.motion).dot(pair.acceleration) +
              Scales::min_force * model_.scales.force / model_.mass[source.index];
      break;
    default:
      value = pair.motion.slip().norm() - rest;
      break;
  }
  return SPRINGNET_OK;
}

void ContactEvents::find_pair(const Source& source, double time, const State& state, Findings& findings) {
  PairTouch& touch = model_.constraints.bodies().touching()[static_cast<std::size_t>(source.pair)];
  const Vector3 slip = pair_motion(model_.constraints.bodies(), touch, read_only(state.view.position),
                                   read_only(state.view.velocity), model_.node_count())
                           .slip();
  const double rest = model_.contact.rest_speed(), speed = slip.norm();
  const auto finding = [&]() -> PairFinding& { return findings.pairs[touch.key()]; };
  const auto go_on = [&] {
    if (speed > 0.0) touch.slip = slip / speed;
    touch.phase = Contact::Slip::ongoing;
    model_.changed();
  };
  const auto slow_down = [&] {
    keep_direction_of_pair(model_, time, state, touch);
    model_.changed();
  };
  switch (source.kind) {
    case Kind::release:
      finding().released = true;
      model_.changed();  // the offset follows the forces
      break;
    case Kind::seam:
      finding().at_border = true;
      model_.changed();  // the force may jump
      break;
    case Kind::slip:
      finding().slips = true;
      break;
    case Kind::slow:
      slow_down();
      break;
    case Kind::quick:
      go_on();
      break;
    case Kind::stall:
      if (touch.slip.dot(slip) > model_.no_speed())
        slow_down();
      else
        finding().slip_ended = true;
      break;
    default:  // its end, unless it turned by a right angle
      if (speed > rest && std::abs(touch.slip.dot(slip)) <= rest)
        go_on();
      else
        finding().slip_ended = true;
      break;
  }
}

void ContactEvents::find_impacts(const State& state, Findings& findings) {
  const BodyContacts& bodies = model_.constraints.bodies();
  const proximity::Positions x = positions_of(read_only(state.view.position), model_.node_count());
  for (const proximity::NearPair& each :
       pairs_apart_within(model_, read_only(state.view.position), model_.contact_tolerance())) {
    const PairMotion motion = pair_motion(bodies, each.kind, each.pair, read_only(state.view.position),
                                          read_only(state.view.velocity), model_.node_count());
    if (motion.normal.dot(motion.velocity) < -model_.no_speed() &&
        !is_said_by_touching(bodies, each.kind, each.pair, motion.weights, x)) {
      findings.pairs[{each.kind, each.pair}];
      model_.changed();  // the depth at which it touches follows its position, where it turns round before
    }
  }
}

}  // namespace springnet
