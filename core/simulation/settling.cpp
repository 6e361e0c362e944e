#include "simulation/settling.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "constraints/friction.hpp"
#include "constraints/vectors.hpp"
#include "simulation/contact_notes.hpp"
#include "simulation/pair_events.hpp"

namespace springnet {
namespace {

constexpr double jump = 1e-6;  // in units of the velocity scale
// In the same units, of slips: what impulses leave where pairs are nearly redundant.
constexpr double creep = 1e-9;
// Slower rebounds, in units of the velocity scale, end: there are infinitely many in a finite time, and the fall within
// the contact tolerance would make up for the energy of the last ones. Rebounds slower than `steps_of_fall` times the
// speed gained in a step end, too.
constexpr double min_rebound = 1e-4;
constexpr double steps_of_fall = 2.0;
// In the same units. Integration errors decide whether slower touches happen.
constexpr double grazing = 1e-4;
constexpr int max_jams = 20, max_returns = 20;
constexpr double caught = 0.01;  // of the speed with which obstacles approached a body
// `many_touches` of a node, each within `soon` (in units of the time to move the length scale) of the one before, show
// a body that rocks on its contacts ever faster. Motions slower than `slow_rocking`, in units of the velocity scale,
// then end.
constexpr int many_touches = 8;
constexpr double soon = 1e-3, slow_rocking = 1e-3;
// A node that separates more slowly, in units of the speed gained in a fall through the contact tolerance, stays in
// contact: it would be back at once, as fast.
constexpr double times_of_fall = 2.0;
// Touches within this many of the user's time steps are a quick succession too.
constexpr double few_steps = 4.0;

}  // namespace

Settling::Settling(Model& model, double time, State& state, const Findings& findings)
    : model_(model),
      time_(time),
      state_(state),
      findings_(findings),
      at_(model.placement(time)),
      depth_(model.contact_tolerance()),
      no_speed_(model.no_speed()),
      jump_(jump * model.scales.velocity),
      creep_(creep * model.scales.velocity),
      done_(model.rigid.cluster_count(), 0),
      clusters_(model) {}

springnet_status settle(Model& model, double time, State& state, const Findings& findings) {
  Settling settling(model, time, state, findings);
  for (const auto& [node, finding] : findings.nodes)
    if (const springnet_status status = settling.settle(node); status != SPRINGNET_OK) return status;
  if (const springnet_status status = settling.settle_pairs(); status != SPRINGNET_OK) return status;
  return settling.finish();
}

const Finding& Settling::finding(std::uint32_t node) const {
  static const Finding none;
  const auto found = findings_.nodes.find(node);
  return found == findings_.nodes.end() ? none : found->second;
}

bool Settling::turns_round(std::uint32_t node, const ContactSide& side) const {
  ReactionsAt reactions(model_, time_, read_only(state_.view.position), read_only(state_.view.velocity));
  Vector3 acceleration;
  if (reactions.acceleration(node, acceleration) != SPRINGNET_OK) return false;
  const double speed = side.normal.dot(side.velocity), grows = side.normal.dot(acceleration) - side.target_acceleration;
  return grows > 0.0 && speed * speed <= 2.0 * grows * uncertain * model_.scales.length;
}

void Settling::add_sides(ContactNode& node) const {
  const Contact& contact = model_.contact;
  const Finding& found = finding(node.node);
  const Touch touch = contact.committed(node.node);
  const Vector3 p = vector_at(state_.view.position, node.node), v = vector_at(state_.view.velocity, node.node);
  const auto is_in = [](const std::vector<std::int32_t>& list, std::int32_t surface) {
    return std::find(list.begin(), list.end(), surface) != list.end();
  };
  // Obstacles in contact come first; a fourth would constrain nothing more.
  std::vector<std::int32_t> surfaces;
  for (const std::int32_t surface : touch.surfaces())
    if (surface >= 0) surfaces.push_back(surface);
  for (std::int32_t surface = 0; surface < static_cast<std::int32_t>(contact.obstacles().size()); ++surface)
    if (!touch.has(surface)) surfaces.push_back(surface);
  for (const std::int32_t surface : surfaces) {
    if (node.sides.size() == 3) break;
    const auto j = static_cast<std::size_t>(surface);
    const bool was = touch.has(surface);
    const double gap = was ? 0.0 : contact.gap(*at_, j, p);
    if (gap > depth_ && !is_in(found.touched, surface)) continue;
    const Obstacle& obstacle = contact.obstacles()[j];
    ContactSide side;
    side.surface = surface;
    side.normal = contact.normal(*at_, j, p);
    side.friction = clusters_.any() || group_ != nullptr ? bounded(obstacle.friction()) : obstacle.friction();
    side.restitution = obstacle.restitution();
    side.velocity = v - Contact::velocity(*at_, j, p);
    side.surface_acceleration = Contact::acceleration(*at_, j, p);
    side.target_acceleration =
        side.normal.dot(side.surface_acceleration) - contact.bias_acceleration(*at_, j, p, side.velocity);
    side.active = was && !is_in(found.released, surface);
    const double speed = side.normal.dot(side.velocity);
    if (!was) {
      if (speed > no_speed_) continue;
      // A node just released: only the uncertainty of its gap crossed the tolerance again.
      if (speed < -no_speed_ && touch.surface < 0 && gap > -shallow * model_.scales.length &&
          turns_round(node.node, side))
        continue;
      if (speed < -no_speed_ && -speed < grazing * model_.scales.velocity && side.restitution == 0.0)
        note_grazing_touch(model_, node.node, j, time_);
    }
    // Integration errors along a direction constrained by the contact.
    const double least = was ? jump_ : no_speed_;
    if (std::abs(speed) <= least) side.velocity -= speed * side.normal;
    node.sides.push_back(side);
  }
  node.slid = touch.slides;
  node.slip_ended = found.slip_ended && touch.slides;
  node.braced = contact.braced(node.node) && found.released.empty();
}

// Gives sticking nodes the velocity of their obstacle again if they differ by integration errors.
void Settling::restore_sticking() {
  const Contact& contact = model_.contact;
  for (const std::uint32_t k : members_) {
    const Touch touch = contact.committed(k);
    if (touch.surface < 0 || touch.slides) continue;
    const auto j = static_cast<std::size_t>(touch.surface);
    const Vector3 w = Contact::velocity(*at_, j, vector_at(state_.view.position, k));
    if ((vector_at(state_.view.velocity, k) - w).norm() <= jump_) put_vector(state_.view.velocity, k, w);
  }
}

std::vector<ContactNode> Settling::gather() const {
  std::vector<ContactNode> nodes;
  for (const std::uint32_t k : members_) {
    if (model_.contact.fixed()[k] != 0 || model_.contact.obstacles().empty()) continue;
    ContactNode node;
    node.node = k;
    add_sides(node);
    if (!node.sides.empty()) nodes.push_back(std::move(node));
  }
  if (group_ != nullptr) add_pairs(nodes);
  return nodes;
}

springnet_status Settling::accelerate(Island& island) {
  const springnet_const_vectors position = read_only(state_.view.position), velocity = read_only(state_.view.velocity);
  ReactionsAt reactions(model_, time_, position, velocity);
  std::vector<Vector3> accelerations(members_.size());
  for (std::size_t i = 0; i < members_.size(); ++i)
    if (const springnet_status status = reactions.unsupported(members_[i], accelerations[i]); status != SPRINGNET_OK)
      return status;
  const auto find = [&](std::uint32_t k) -> Vector3* {
    const auto place = std::lower_bound(members_.begin(), members_.end(), k);
    if (place == members_.end() || *place != k) return nullptr;
    return &accelerations[static_cast<std::size_t>(place - members_.begin())];
  };
  for (const auto& [number, rods] : clusters_.clusters()) {
    const std::vector<std::uint32_t>& joined = model_.rigid.nodes_of(number);
    std::vector<Vector3> of_cluster;
    for (const std::uint32_t k : joined) of_cluster.push_back(*find(k));
    rods.accelerate(position, velocity, of_cluster);
    for (std::size_t i = 0; i < joined.size(); ++i) *find(joined[i]) = of_cluster[i];
  }
  const auto acceleration_of = [&](std::uint32_t k) -> Vector3 {
    if (const Vector3* const known = find(k)) return *known;
    Vector3 moved;  // of one that is fixed or moved, which is no member
    return reactions.unsupported(k, moved) == SPRINGNET_OK ? moved : Vector3::Zero();
  };
  for (ContactNode& node : island.nodes()) {
    if (node.pair >= 0) {
      const PairMotion motion = motion_of(candidates_[static_cast<std::size_t>(node.pair)]);
      node.acceleration = motion.relative(acceleration_of);
      node.sides[0].target_acceleration = -motion.bias;
      continue;
    }
    node.acceleration = acceleration_of(node.node);
    const Vector3 p = vector_at(position, node.node);
    for (ContactSide& side : node.sides) {
      const auto j = static_cast<std::size_t>(side.surface);
      side.target_acceleration =
          side.normal.dot(side.surface_acceleration) - model_.contact.bias_acceleration(*at_, j, p, side.velocity);
    }
  }
  return SPRINGNET_OK;
}

void Settling::apply_impulses(const Island& island) {
  Contact& contact = model_.contact;
  std::map<std::uint32_t, Vector3> impulses;
  for (const ContactNode& node : island.nodes()) {
    if (node.pair >= 0) {
      apply_impulse(candidates_[static_cast<std::size_t>(node.pair)], node.impulse[0]);
      continue;
    }
    Vector3 sum = Vector3::Zero();
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      sum += node.impulse[s];
      contact.add_surface_impulse(static_cast<std::size_t>(node.sides[s].surface), -node.impulse[s]);
    }
    contact.add_impulse(node.node, sum);
    impulses.emplace(node.node, sum);
  }
  spread(impulses);
  struck_ = true;
}

// The fixation of a node takes the impulses that reach it.
void Settling::spread(const std::map<std::uint32_t, Vector3>& impulses) {
  const springnet_vectors& velocity = state_.view.velocity;
  clusters_.spread(
      impulses, [&](std::uint32_t k, const Vector3& dv) { put_vector(velocity, k, vector_at(velocity, k) + dv); },
      [this](std::uint32_t k, const Vector3& impulse) { model_.contact.add_impulse(k, -impulse); });
}

// Commits the contact that was found for a node.
void Settling::commit_contact(const ContactNode& node, const Vector3& came) {
  if (node.pair >= 0) return commit_pair(node, came);
  Contact& contact = model_.contact;
  const std::uint32_t k = node.node;
  const Model::NodeAt at{vector_at(state_.view.position, k), came};
  const auto record = [&](Event::Kind kind, std::int32_t surface, const Vector3& impulse = Vector3::Zero()) {
    model_.record(kind, time_, k, surface, at, *at_, impulse);
  };
  const Touch before = contact.committed(k);
  Touch now = before;
  bool arrived = false;
  for (const ContactSide& side : node.sides) {
    if (side.active || !before.has(side.surface)) continue;
    now = after(now, {ContactCause::Kind::release, side.surface});
    record(Event::Kind::released, side.surface);
    if (!side.separating) part(k, side);
  }
  const bool stays = now.surface >= 0;
  for (std::size_t s = 0; s < node.sides.size(); ++s) {
    const ContactSide& side = node.sides[s];
    if (before.has(side.surface)) continue;
    if (!side.active && node.impulse[s].isZero(0.0)) continue;
    // The impulses that end rocking may draw a node back; these are not impacts.
    const bool pulls = side.normal.dot(node.impulse[s]) < 0.0;
    record(Event::Kind::touched, side.surface, pulls ? Vector3(Vector3::Zero()) : node.impulse[s]);
    if (side.active) {
      now = after(now, {ContactCause::Kind::touch, side.surface, node.sticks});
      arrived = true;
    } else {
      // It rebounds from the surface itself, so that its next touch falls through the tolerance again.
      record(Event::Kind::released, side.surface);
      put_vector(state_.view.position, k,
                 contact.onto(*at_, static_cast<std::size_t>(side.surface), vector_at(state_.view.position, k)));
      rebounds_[k].push_back(side.surface);
    }
  }
  now = after(now, {node.sticks ? ContactCause::Kind::stick : ContactCause::Kind::slip});
  if (stays && finding(k).slip_ended) record(Event::Kind::stuck, now.surface);
  if (stays && now.slides != (before.slides && !finding(k).slip_ended))
    record(now.slides ? Event::Kind::slipped : Event::Kind::stuck, now.surface);
  if (now != before || finding(k).slip_ended || finding(k).slips) model_.changed();
  const bool was_braced = contact.braced(k),
             braced = node.braced && node.sticks && now.count() == 1 && group_ == nullptr;
  if (was_braced != braced) model_.changed();
  contact.touch(k, now, Vector3::Zero());
  contact.set_braced(k, braced);
  if (now.surface < 0) return;
  const springnet_vectors &position = state_.view.position, &velocity = state_.view.velocity;
  const auto j = static_cast<std::size_t>(now.surface);
  if (arrived || now.slides) contact.project_sliding(*at_, k, position, velocity);
  if (!now.slides) {
    put_vector(velocity, k, Contact::velocity(*at_, j, vector_at(position, k)));
    if (arrived) stopped_.push_back(k);
    return;
  }
  // Slow slips are treated when the whole island has its contacts, see find_phase().
  const Vector3 slip = contact.slip_vector(*at_, k, j, vector_at(position, k), vector_at(velocity, k));
  const bool begins = !node.slipping || node.slip_starting;
  if (begins)
    set_slip(k, node.slip, Contact::Slip::starting);
  else if (!before.slides || contact.slip_phase(k) != Contact::Slip::ending)
    set_slip(k, slip.normalized(), Contact::Slip::ongoing);
}

// A released node starts without normal speed relative to the obstacle: an integration error would make it touch again.
void Settling::part(std::uint32_t node, const ContactSide& side) {
  if (model_.rigid.is_joined(node)) return;
  const Vector3 v = vector_at(state_.view.velocity, node);
  const auto j = static_cast<std::size_t>(side.surface);
  const double speed = side.normal.dot(v - Contact::velocity(*at_, j, vector_at(state_.view.position, node)));
  if (std::abs(speed) > jump_) return;
  put_vector(state_.view.velocity, node, v - speed * side.normal);
  const Vector3 impulse = -model_.mass[node] * speed * side.normal;
  model_.contact.add_impulse(node, impulse);
  model_.contact.add_surface_impulse(j, -impulse);
}

bool Settling::chatters(const Island& island) {
  const double short_time =
      std::max(soon * model_.scales.length / model_.scales.velocity, few_steps * model_.step_length);
  bool result = false;
  std::set<std::uint32_t> counted;  // a node may be in many pairs
  for (const ContactNode& node : island.nodes()) {
    const bool struck = std::any_of(node.impulse.begin(), node.impulse.end(),
                                    [](const Vector3& impulse) { return !impulse.isZero(0.0); });
    const bool was = node.pair < 0 ? model_.contact.committed(node.node).surface >= 0
                                   : candidates_[static_cast<std::size_t>(node.pair)].was;
    if (!struck || was || !counted.insert(node.node).second) continue;
    const int touches = model_.recent_touches.count(node.node, time_, short_time);
    result = result || touches >= many_touches;
  }
  return result;
}

double Settling::fall_in_step(Island& island) {
  if (model_.step_length == 0.0 || accelerate(island) != SPRINGNET_OK) return 0.0;
  double falls = 0.0;
  for (const ContactNode& node : island.nodes())
    for (const ContactSide& side : node.sides)
      falls = std::max(falls, side.target_acceleration - side.normal.dot(node.acceleration));
  return steps_of_fall * model_.step_length * falls;
}

double Settling::uncertainty() const noexcept { return std::max(depth_, model_.position_uncertainty); }

double Settling::fall_through(Island& island, double depth) {
  if (accelerate(island) != SPRINGNET_OK) return 0.0;
  double falls = 0.0;
  for (const ContactNode& node : island.nodes())
    for (const ContactSide& side : node.sides)
      falls = std::max(falls, side.target_acceleration - side.normal.dot(node.acceleration));
  return times_of_fall * std::sqrt(2.0 * falls * depth);
}

double Settling::rebound_of(Island& island) {
  const double least = min_rebound * model_.scales.velocity;
  for (const ContactNode& node : island.nodes())
    for (const ContactSide& side : node.sides)
      if (side.restitution > 0.0)
        return std::max({least, fall_in_step(island), group_ == nullptr ? 0.0 : fall_through(island, uncertainty())});
  return least;
}

springnet_status Settling::settle(std::uint32_t node) {
  const std::uint32_t* clusters = model_.rigid.cluster_of();
  clusters_.clear();
  group_ = nullptr;
  gather_candidates();
  if (const auto group = group_of_.find(node); group != group_of_.end()) {
    if (group_done_[group->second] != 0) return SPRINGNET_OK;
    group_done_[group->second] = 1;
    group_ = &groups_[group->second];
    members_ = group_->nodes;
    clusters_.set(members_, read_only(state_.view.position));
    clusters_.add_nodes(members_);
    for (const auto& [number, rods] : clusters_.clusters()) done_[number] = 1;
  } else if (clusters != nullptr && clusters[node] != ConstraintRow::no_node) {
    const std::uint32_t cluster = clusters[node];
    if (done_[cluster] != 0) return SPRINGNET_OK;
    done_[cluster] = 1;
    members_ = model_.rigid.nodes_of(cluster);
    clusters_.set({node}, read_only(state_.view.position));
  } else {
    members_ = {node};
  }
  restore_sticking();
  // Integration errors in the rates of lengths, which impulses of contacts could not remove.
  for (const auto& [number, rods] : clusters_.clusters()) rods.project(state_.view.velocity);
  std::vector<ContactNode> nodes = gather();
  if (nodes.empty()) return SPRINGNET_OK;
  const Eigen::MatrixXd response = mobility(nodes);
  Island island(std::move(nodes), response);
  std::vector<Vector3> came;  // m/s, [node of the island]
  for (const ContactNode& each : island.nodes())
    came.push_back(each.pair < 0 ? vector_at(state_.view.velocity, each.node)
                                 : first_velocity(candidates_[static_cast<std::size_t>(each.pair)].motion,
                                                  read_only(state_.view.velocity)));
  const double approached = island.approach();
  bool struck = island.apply_impact(rebound_of(island), no_speed_);
  // No impulses end the approach of obstacles between which a body is caught.
  if (island.approach() > std::max(caught * approached, jump_)) {
    std::set<std::int32_t> surfaces;
    for (const ContactNode& each : island.nodes())
      for (const ContactSide& side : each.sides)
        if (side.surface >= 0) surfaces.insert(side.surface);
    std::string bodies;
    for (const ContactNode& each : island.nodes())
      if (each.pair >= 0 && bodies.empty()) {
        const PairTouch& touch = candidates_[static_cast<std::size_t>(each.pair)].touch;
        bodies = "bodies, such as " + model_.constraints.bodies().describe(touch.kind, touch.pair);
      }
    return no_place(model_, node, {surfaces.begin(), surfaces.end()}, time_, bodies);
  }
  struck = stop_held(island, jump_) || struck;
  std::vector<std::vector<Vector3>> impulses;  // N s, [node of the island][side]
  for (const ContactNode& each : island.nodes()) impulses.emplace_back(each.sides.size(), Vector3::Zero());
  const bool hit = struck;
  bool returned = false;
  int returns = 0;
  holds_ = flutters();
  for (int jams = 0;; jams += returned ? 0 : 1) {
    if (struck && !returned) {
      const bool rocks = chatters(island);
      const double slow = std::max({fall_through(island, depth_), rocks ? slow_rocking * model_.scales.velocity : 0.0,
                                    rocks ? fall_in_step(island) : 0.0});
      island.end_rocking(slow, rocks || group_ == nullptr);
      // Impulses along the normals alone turn the body; the slip left by that would go on against friction, for which
      // there may be no finite forces.
      if (rocks) stop_held(island, slow);
    }
    if (struck) apply_impulses(island);
    for (std::size_t i = 0; struck && i < impulses.size(); ++i)
      for (std::size_t s = 0; s < impulses[i].size(); ++s) impulses[i][s] += island.nodes()[i].impulse[s];
    if (const springnet_status status = accelerate(island); status != SPRINGNET_OK) return status;
    find_slips(island);
    begin_slips(island);
    // Large forces of stiff springs cancel, up to rounding.
    double forces = 0.0;
    for (const ContactNode& each : island.nodes())
      forces = std::max(forces, model_.mass[each.node] * each.acceleration.norm());
    const double negligible = Scales::min_force * model_.scales.force + 1e-12 * forces;
    if (holds_) {
      note_unresolved(model_, node, time_);
      if (const springnet_status status = stop_and_stick(island, negligible, jump_, impulses); status != SPRINGNET_OK)
        return status;
      break;
    }
    const bool is_resolved = island.resolve(negligible);
    for (ContactNode& each : island.nodes()) std::fill(each.impulse.begin(), each.impulse.end(), Vector3::Zero());
    const double short_way = times_of_fall * times_of_fall * depth_;
    returned = is_resolved && returns++ < max_returns &&
               (island.end_returns(short_way) || island.end_short_slips(short_way, !hit, creep_, no_speed_));
    if (returned) {
      struck = true;
      continue;
    }
    if (is_resolved) break;
    struck = jams < max_jams && island.jam(10.0 * no_speed_);
    if (!struck) {
      note_unresolved(model_, node, time_);
      if (const springnet_status status =
              stop_and_stick(island, negligible, slow_rocking * model_.scales.velocity, impulses);
          status != SPRINGNET_OK)
        return status;
      break;
    }
    for (std::size_t i = 0; i < island.nodes().size(); ++i) {
      const ContactNode& each = island.nodes()[i];
      for (std::size_t s = 0; s < each.sides.size(); ++s)
        if (each.pair < 0 && !each.impulse[s].isZero(0.0))
          model_.record(Event::Kind::jammed, time_, each.node, each.sides[s].surface,
                        {vector_at(state_.view.position, each.node), came[i]}, *at_, each.impulse[s]);
    }
  }
  for (std::size_t i = 0; i < impulses.size(); ++i) island.nodes()[i].impulse = impulses[i];
  for (std::size_t i = 0; i < island.nodes().size(); ++i) commit_contact(island.nodes()[i], came[i]);
  if (group_ != nullptr) push_apart(island, response);
  for (std::size_t i = 0; i < island.nodes().size(); ++i) {
    const ContactNode& each = island.nodes()[i];
    find_phase(each, island.acceleration(i), Scales::min_force * model_.scales.force / model_.mass[each.node]);
  }
  return SPRINGNET_OK;
}

springnet_status Settling::finish() {
  put_pairs();
  if (!struck_ && stopped_.empty()) return SPRINGNET_OK;
  model_.changed();
  return model_.constraints.project(*at_, state_.view.position, state_.view.velocity, model_.journal.message, stopped_,
                                    rebounds_);
}

}  // namespace springnet
