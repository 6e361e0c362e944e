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

namespace springnet {
namespace {

// A surface whose velocity jumps leaves a node behind, or strikes it, where that is more than errors of integration, in
// units of the velocity scale.
constexpr double jump = 1e-6;
// What positions of a reference are uncertain by at least, in units of the length scale.
constexpr double uncertain = 1e-8, shallow = 1e-7;
// Rebounds that are slower, in units of the velocity scale, end: there are infinitely many in a finite time, and what
// a node falls within the tolerance of touching makes up for what the last ones lose. Those that are slower than so
// many times what the acceleration adds in a step end too.
constexpr double least_rebound = 1e-4;
constexpr double steps_of_fall = 2.0;
// Touches that are slower depend on errors of integration; likewise.
constexpr double grazing = 1e-4;
// A force this small, in units of the force scale, is rounding: a node was just released by it, say.
constexpr double least_force = 1e-9;
constexpr int most_jams = 20;
constexpr double caught = 0.01;  // of the speed with which a body was approached
// So many touches of a node, each within this part of the time in which it goes a typical length, are a body that rocks
// on its contacts ever faster; what is slower than this, in units of the velocity scale, then ends.
constexpr int many_touches = 8;
constexpr double soon = 1e-3, slow_rocking = 1e-3;
// What leaves a surface more slowly, in units of the speed with which it falls through the tolerance of touching, does
// not leave: it would be back at once, as fast.
constexpr double times_of_fall = 2.0;
constexpr double few_steps = 4.0;  // of a method with steps of its user's

}  // namespace

Engine::Settling::Settling(Engine& engine, double time, State& state, const Findings& findings)
    : engine_(engine),
      time_(time),
      state_(state),
      findings_(findings),
      at_(engine.placement(time)),
      depth_(engine.contact_tolerance()),
      no_speed_(engine.no_speed()),
      done_(engine.rigid_.cluster_count(), 0) {}

const Engine::Finding& Engine::Settling::finding(std::uint32_t node) const {
  static const Finding none;
  const auto found = findings_.find(node);
  return found == findings_.end() ? none : found->second;
}

void Engine::Settling::tell(Event::Kind kind, std::uint32_t node, std::int32_t surface, const Vector3& impulse) {
  Event event{kind, time_, engine_.layout_.ordering().user[node]};
  event.surface = surface;
  event.impulse = impulse;
  engine_.events_.push_back(event);
}

bool Engine::Settling::turns_round(std::uint32_t node, const ContactSide& side) const {
  ReactionsAt reactions(engine_, time_, read_only(state_.view.position), read_only(state_.view.velocity));
  Vector3 acceleration;
  if (reactions.acceleration(node, acceleration) != SPRINGNET_OK) return false;
  const double speed = side.normal.dot(side.velocity), grows = side.normal.dot(acceleration) - side.needed;
  return grows > 0.0 && speed * speed <= 2.0 * grows * uncertain * engine_.info_.length_scale;
}

void Engine::Settling::add_sides(ContactNode& node) const {
  const Contact& contact = engine_.contact_;
  const Finding& found = finding(node.node);
  const Touch touch = contact.committed(node.node);
  const Vector3 p = vector_at(state_.view.position, node.node), v = vector_at(state_.view.velocity, node.node);
  const auto is_in = [](const std::vector<std::int32_t>& list, std::int32_t surface) {
    return std::find(list.begin(), list.end(), surface) != list.end();
  };
  // Those that it touches come first; a fourth would bind nothing.
  std::vector<std::int32_t> surfaces;
  for (const std::int32_t surface : touch.surfaces())
    if (surface >= 0) surfaces.push_back(surface);
  for (std::int32_t surface = 0; surface < static_cast<std::int32_t>(contact.surfaces().size()); ++surface)
    if (!touch.has(surface)) surfaces.push_back(surface);
  for (const std::int32_t surface : surfaces) {
    if (node.sides.size() == 3) break;
    const auto j = static_cast<std::size_t>(surface);
    const bool was = touch.has(surface);
    const double gap = was ? 0.0 : contact.gap(*at_, j, p);
    if (gap > depth_ && !is_in(found.touched, surface)) continue;
    const Obstacle& obstacle = contact.surfaces()[j];
    ContactSide side;
    side.surface = surface;
    side.normal = contact.normal(*at_, j, p);
    side.friction = rods_ ? bounded(obstacle.friction()) : obstacle.friction();
    side.restitution = obstacle.restitution();
    side.velocity = v - Contact::velocity(*at_, j, p);
    side.surface_acceleration = Contact::acceleration(*at_, j, p);
    side.needed = side.normal.dot(side.surface_acceleration) - contact.bias_acceleration(*at_, j, p, side.velocity);
    side.touches = was && !is_in(found.released, surface);
    const double speed = side.normal.dot(side.velocity);
    if (!was) {
      if (speed > no_speed_) continue;
      // Just released, what the distance is uncertain by crossed the tolerance once more.
      if (speed < -no_speed_ && touch.surface < 0 && gap > -shallow * engine_.info_.length_scale &&
          turns_round(node.node, side))
        continue;
      if (speed < -no_speed_ && -speed < grazing * engine_.info_.velocity_scale && side.restitution == 0.0)
        engine_.note_grazing(node.node, j, time_);
    }
    // What integration leaves of a motion that the contact does not allow.
    const double least = was ? jump * engine_.info_.velocity_scale : no_speed_;
    if (std::abs(speed) <= least) side.velocity -= speed * side.normal;
    node.sides.push_back(side);
  }
  node.rests = found.rests && touch.slides;
  node.braced = contact.braced(node.node) && found.released.empty();
}

// Nodes that stick have the velocity of their surface, without what integration made of it.
void Engine::Settling::take_along() {
  const Contact& contact = engine_.contact_;
  for (const std::uint32_t k : members_) {
    const Touch touch = contact.committed(k);
    if (touch.surface < 0 || touch.slides) continue;
    const auto j = static_cast<std::size_t>(touch.surface);
    const Vector3 w = Contact::velocity(*at_, j, vector_at(state_.view.position, k));
    if ((vector_at(state_.view.velocity, k) - w).norm() <= jump * engine_.info_.velocity_scale)
      put_vector(state_.view.velocity, k, w);
  }
}

std::vector<ContactNode> Engine::Settling::gather() const {
  std::vector<ContactNode> nodes;
  for (const std::uint32_t k : members_) {
    if (engine_.contact_.fixed()[k] != 0) continue;
    ContactNode node;
    node.node = k;
    add_sides(node);
    if (!node.sides.empty()) nodes.push_back(std::move(node));
  }
  return nodes;
}

springnet_status Engine::Settling::accelerate(Island& island) {
  const springnet_const_vectors position = read_only(state_.view.position), velocity = read_only(state_.view.velocity);
  ReactionsAt reactions(engine_, time_, position, velocity);
  std::vector<Vector3> accelerations(members_.size());
  for (std::size_t i = 0; i < members_.size(); ++i)
    if (const springnet_status status = reactions.unsupported(members_[i], accelerations[i]); status != SPRINGNET_OK)
      return status;
  if (rods_) rods_->accelerate(position, velocity, accelerations);
  for (ContactNode& node : island.nodes()) {
    const auto place = std::lower_bound(members_.begin(), members_.end(), node.node) - members_.begin();
    node.acceleration = accelerations[static_cast<std::size_t>(place)];
    const Vector3 p = vector_at(position, node.node);
    for (ContactSide& side : node.sides) {
      const auto j = static_cast<std::size_t>(side.surface);
      side.needed =
          side.normal.dot(side.surface_acceleration) - engine_.contact_.bias_acceleration(*at_, j, p, side.velocity);
    }
  }
  return SPRINGNET_OK;
}

void Engine::Settling::strike(const Island& island) {
  Contact& contact = engine_.contact_;
  const springnet_vectors& velocity = state_.view.velocity;
  std::vector<Vector3> impulses;
  for (const ContactNode& node : island.nodes()) {
    Vector3 sum = Vector3::Zero();
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      sum += node.impulse[s];
      contact.add_surface_impulse(static_cast<std::size_t>(node.sides[s].surface), -node.impulse[s]);
    }
    contact.add_impulse(node.node, sum);
    impulses.push_back(sum);
  }
  const auto change = [&](std::uint32_t node, const Vector3& dv) {
    if (contact.fixed()[node] == 0) put_vector(velocity, node, vector_at(velocity, node) + dv);
  };
  if (rods_) {
    // What fixes a node bears what reaches it.
    rods_->push(contact_nodes_, impulses, change,
                [&](std::uint32_t node, const Vector3& impulse) { contact.add_impulse(node, -impulse); });
  } else {
    change(contact_nodes_.front(), impulses.front() / engine_.mass_[contact_nodes_.front()]);
  }
  struck_ = true;
}

void Engine::Settling::find_slips(Island& island) const {
  for (ContactNode& node : island.nodes()) {
    std::vector<Vector3> normals;
    const ContactSide* first = nullptr;
    double friction = 0.0;
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      ContactSide& side = node.sides[s];
      side.leaves = side.normal.dot(side.velocity) > no_speed_;
      // What arrived and was stopped lies there, though no force presses it.
      const bool arrived = !node.impulse[s].isZero(0.0) && !engine_.contact_.committed(node.node).has(side.surface);
      side.touches = !side.leaves && (side.touches || arrived);
      if (side.leaves) continue;
      normals.push_back(side.normal);
      friction += coefficient_of(side.friction);
      if (first == nullptr) first = &side;
    }
    node.moves = node.sticks = false;
    if (first == nullptr) continue;
    const Vector3 slip = split_reaction(normals, first->velocity).along;
    node.moves = slip.norm() > no_speed_ && friction > 0.0;
    if (node.moves) node.slip = slip.normalized();
    node.sticks = !node.moves && friction > 0.0 && surfaces_move_alike(node, jump * engine_.info_.velocity_scale);
    // Friction acts as it did: against what has no speed yet, or one that errors of integration have a part in.
    if (!engine_.contact_.committed(node.node).slides || node.rests || friction == 0.0) continue;
    const Contact::Slip phase = engine_.contact_.slip_phase(node.node);
    if (phase == Contact::Slip::goes_on || (phase == Contact::Slip::ends && !node.moves)) continue;
    node.begins = phase == Contact::Slip::begins;
    node.sticks = false;
    node.slip = engine_.contact_.slip(node.node);
  }
}

// Nodes that were seen to slip, by the forces that held them until now.
void Engine::Settling::begin_slips(Island& island) const {
  const auto slips = [this](const ContactNode& node) { return node.sticks && finding(node.node).slips; };
  if (std::none_of(island.nodes().begin(), island.nodes().end(), slips)) return;
  island.solve();
  for (std::size_t i = 0; i < island.nodes().size(); ++i)
    if (slips(island.nodes()[i]) && !island.release_held(i)) island.begin_slip(i);
}

// The contact that was found for a node becomes the node's.
void Engine::Settling::take(const ContactNode& node) {
  Contact& contact = engine_.contact_;
  const std::uint32_t k = node.node;
  const Touch before = contact.committed(k);
  Touch now = before;
  bool arrived = false;
  for (const ContactSide& side : node.sides) {
    if (side.touches || !before.has(side.surface)) continue;
    now = after(now, {ContactCause::Kind::release, side.surface});
    tell(Event::Kind::released, k, side.surface);
    if (!side.leaves) part(k, side);
  }
  const bool stays = now.surface >= 0;
  for (std::size_t s = 0; s < node.sides.size(); ++s) {
    const ContactSide& side = node.sides[s];
    if (before.has(side.surface)) continue;
    if (!side.touches && node.impulse[s].isZero(0.0)) continue;
    // What ends the rocking of a body may draw a node back; that is no blow.
    const bool pulls = side.normal.dot(node.impulse[s]) < 0.0;
    tell(Event::Kind::touched, k, side.surface, pulls ? Vector3(Vector3::Zero()) : node.impulse[s]);
    if (side.touches) {
      now = after(now, {ContactCause::Kind::touch, side.surface, node.sticks});
      arrived = true;
    } else {
      // It rebounds, from the surface itself: the next touch is one that falls through the tolerance again.
      tell(Event::Kind::released, k, side.surface);
      put_vector(state_.view.position, k,
                 contact.onto(*at_, static_cast<std::size_t>(side.surface), vector_at(state_.view.position, k)));
      rebounds_[k].push_back(side.surface);
    }
  }
  now = after(now, {node.sticks ? ContactCause::Kind::stick : ContactCause::Kind::slip});
  if (stays && finding(k).rests) tell(Event::Kind::stuck, k, now.surface);
  if (stays && now.slides != (before.slides && !finding(k).rests))
    tell(now.slides ? Event::Kind::slipped : Event::Kind::stuck, k, now.surface);
  if (now != before || finding(k).rests || finding(k).slips) engine_.changed();
  const bool was_braced = contact.braced(k), braced = node.braced && node.sticks && now.count() == 1;
  if (was_braced != braced) engine_.changed();
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
  // What slips slowly, and how, is found once all of the island has its contacts.
  const Vector3 slip = contact.slip_vector(*at_, k, j, vector_at(position, k), vector_at(velocity, k));
  const bool begins = !node.moves || node.begins;
  if (begins)
    contact.set_slip(k, node.slip, Contact::Slip::begins);
  else if (!before.slides || contact.slip_phase(k) != Contact::Slip::ends)
    contact.set_slip(k, slip.normalized());
}

// Slip that is slow, and becomes slower, is about to end.
void Engine::Settling::find_phase(const ContactNode& node, const Vector3& acceleration, double negligible) {
  Contact& contact = engine_.contact_;
  const std::uint32_t k = node.node;
  const Touch& touch = contact.committed(k);
  if (!touch.slides || !node.moves || contact.slip_phase(k) == Contact::Slip::ends) return;
  const auto j = static_cast<std::size_t>(touch.surface);
  const Vector3 p = vector_at(state_.view.position, k);
  const Vector3 slip = contact.slip_vector(*at_, k, j, p, vector_at(state_.view.velocity, k));
  const double speed = slip.norm();
  if (speed > contact.rest_speed() && !node.begins) return;
  const double grows = slip.dot(acceleration - Contact::acceleration(*at_, j, p));
  if (grows < -negligible * speed)
    keep_direction(k);
  else if (!node.begins && speed <= 0.5 * contact.rest_speed())
    contact.set_slip(k, slip / speed, Contact::Slip::begins);
}

// Friction keeps the direction from now on in which it ends all of the slip at once, s + T a(t) = 0 with a the
// acceleration against the surface: that which it would have on the average.
void Engine::Settling::keep_direction(std::uint32_t k) {
  Contact& contact = engine_.contact_;
  const Touch touch = contact.committed(k);
  const auto j = static_cast<std::size_t>(touch.surface);
  const Vector3 p = vector_at(state_.view.position, k), v = vector_at(state_.view.velocity, k);
  const Vector3 slip = contact.slip_vector(*at_, k, j, p, v);
  if (slip.isZero(0.0)) return;
  const Vector3 n = contact.normal(*at_, j, p), goes = slip.normalized();
  const auto keep = [&](const Vector3& direction) { contact.set_slip(k, direction, Contact::Slip::ends); };
  keep(goes);
  if (touch.second >= 0 || engine_.coefficient(k, j) >= friction_of_held) return;
  double slows = 0.0;
  const auto found = find_direction(n, goes, [&](const Vector3& against) {
    keep(against);
    ReactionsAt reactions(engine_, time_, read_only(state_.view.position), read_only(state_.view.velocity));
    Vector3 a;
    if (reactions.bound(k, a) != SPRINGNET_OK) return std::numeric_limits<double>::quiet_NaN();
    a -= Contact::acceleration(*at_, j, p);
    slows = -goes.dot(a);
    return n.dot(goes.cross(a));
  });
  // Elsewhere it passes by its end.
  keep(found && found->dot(goes) > 0.0 && slows > 0.0 ? *found : goes);
}

// Ends the slip of nodes that a surface that holds struck, where it is slower than `slow` (m/s): no more than errors of
// integration, or what is left of rocking. Returns whether there was any.
bool Engine::Settling::stop_held(Island& island, double slow) const {
  for (ContactNode& node : island.nodes()) {
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      const ContactSide& side = node.sides[s];
      node.rests = node.rests || (!node.impulse[s].isZero(0.0) && coefficient_of(side.friction) >= friction_of_held &&
                                  side.velocity.norm() <= slow);
    }
  }
  return island.stop(no_speed_);
}

// What is released begins without speed against the surface: what integration left of one would make it touch again.
void Engine::Settling::part(std::uint32_t node, const ContactSide& side) {
  if (rods_) return;
  const Vector3 v = vector_at(state_.view.velocity, node);
  const auto j = static_cast<std::size_t>(side.surface);
  const double speed = side.normal.dot(v - Contact::velocity(*at_, j, vector_at(state_.view.position, node)));
  if (std::abs(speed) > jump * engine_.info_.velocity_scale) return;
  put_vector(state_.view.velocity, node, v - speed * side.normal);
  const Vector3 impulse = -engine_.mass_[node] * speed * side.normal;
  engine_.contact_.add_impulse(node, impulse);
  engine_.contact_.add_surface_impulse(j, -impulse);
}

// Counts touches.
bool Engine::Settling::chatters(const Island& island) {
  const double short_time =
      std::max(soon * engine_.info_.length_scale / engine_.info_.velocity_scale, few_steps * engine_.step_length_);
  bool result = false;
  for (const ContactNode& node : island.nodes()) {
    const bool struck = std::any_of(node.impulse.begin(), node.impulse.end(),
                                    [](const Vector3& impulse) { return !impulse.isZero(0.0); });
    if (!struck || engine_.contact_.committed(node.node).surface >= 0) continue;
    Touches& touches = engine_.touches_[node.node];
    touches.count = time_ - touches.last <= short_time ? touches.count + 1 : 1;
    touches.last = time_;
    result = result || touches.count >= many_touches;
  }
  return result;
}

double Engine::Settling::fall_in_step(Island& island) {
  if (engine_.step_length_ == 0.0 || accelerate(island) != SPRINGNET_OK) return 0.0;
  double falls = 0.0;
  for (const ContactNode& node : island.nodes())
    for (const ContactSide& side : node.sides)
      falls = std::max(falls, side.needed - side.normal.dot(node.acceleration));
  return steps_of_fall * engine_.step_length_ * falls;
}

double Engine::Settling::fall_to_touch(Island& island) {
  if (accelerate(island) != SPRINGNET_OK) return 0.0;
  double falls = 0.0;
  for (const ContactNode& node : island.nodes())
    for (const ContactSide& side : node.sides)
      falls = std::max(falls, side.needed - side.normal.dot(node.acceleration));
  return times_of_fall * std::sqrt(2.0 * falls * depth_);
}

double Engine::Settling::rebound_of(Island& island) {
  const double least = least_rebound * engine_.info_.velocity_scale;
  for (const ContactNode& node : island.nodes())
    for (const ContactSide& side : node.sides)
      if (side.restitution > 0.0) return std::max(least, fall_in_step(island));
  return least;
}

springnet_status Engine::Settling::hold_on(Island& island, double negligible,
                                           std::vector<std::vector<Vector3>>& blows) {
  const double slow = slow_rocking * engine_.info_.velocity_scale;
  for (ContactNode& node : island.nodes()) {
    std::fill(node.impulse.begin(), node.impulse.end(), Vector3::Zero());
    node.rests = std::any_of(node.sides.begin(), node.sides.end(), [&](const ContactSide& side) {
      const double mu = coefficient_of(side.friction);
      return side.touches && mu > 0.0 && (mu >= friction_of_held || side.velocity.norm() <= slow);
    });
  }
  if (island.stop(no_speed_)) {
    strike(island);
    for (std::size_t i = 0; i < blows.size(); ++i)
      for (std::size_t s = 0; s < blows[i].size(); ++s) blows[i][s] += island.nodes()[i].impulse[s];
    if (const springnet_status status = accelerate(island); status != SPRINGNET_OK) return status;
  }
  for (ContactNode& node : island.nodes()) {
    if (!node.rests) continue;
    node.moves = node.begins = false;
    node.sticks = true;
  }
  island.hold(negligible);
  return SPRINGNET_OK;
}

springnet_status Engine::Settling::settle(std::uint32_t node) {
  const std::uint32_t* clusters = engine_.rigid_.cluster_of();
  rods_.reset();
  if (clusters != nullptr && clusters[node] != ConstraintRow::no_node) {
    const std::uint32_t cluster = clusters[node];
    if (done_[cluster] != 0) return SPRINGNET_OK;
    done_[cluster] = 1;
    members_ = engine_.rigid_.nodes_of(cluster);
    rods_.emplace(engine_.rigid_, cluster, read_only(state_.view.position));
  } else {
    members_ = {node};
  }
  take_along();
  // What integration left of rates of lengths no impulses could end.
  if (rods_) rods_->project(state_.view.velocity);
  std::vector<ContactNode> nodes = gather();
  if (nodes.empty()) return SPRINGNET_OK;
  contact_nodes_.clear();
  for (const ContactNode& each : nodes) contact_nodes_.push_back(each.node);
  Island island(std::move(nodes), rods_ ? rods_->mobility(contact_nodes_)
                                        : Eigen::MatrixXd(Eigen::MatrixXd::Identity(3, 3) / engine_.mass_[node]));
  const double approached = island.approach();
  bool struck = island.strike(rebound_of(island), no_speed_);
  // No impulses end the approach of surfaces between which a body is caught.
  if (island.approach() > std::max(caught * approached, jump * engine_.info_.velocity_scale)) {
    std::set<std::int32_t> surfaces;
    for (const ContactNode& each : island.nodes())
      for (const ContactSide& side : each.sides) surfaces.insert(side.surface);
    return engine_.no_place(node, {surfaces.begin(), surfaces.end()}, time_);
  }
  struck = stop_held(island, jump * engine_.info_.velocity_scale) || struck;
  std::vector<std::vector<Vector3>> blows;  // N s, [node of the island][side]
  for (const ContactNode& each : island.nodes()) blows.emplace_back(each.sides.size(), Vector3::Zero());
  for (int jams = 0;; ++jams) {
    if (struck) {
      const bool rocks = chatters(island);
      const double slow = std::max({fall_to_touch(island), rocks ? slow_rocking * engine_.info_.velocity_scale : 0.0,
                                    rocks ? fall_in_step(island) : 0.0});
      island.end_rocking(slow);
      // Its impulses, across the surfaces alone, turn the body: left as a slip, that would go on against friction that
      // no finite forces fit.
      if (rocks) stop_held(island, slow);
    }
    if (struck) strike(island);
    for (std::size_t i = 0; struck && i < blows.size(); ++i)
      for (std::size_t s = 0; s < blows[i].size(); ++s) blows[i][s] += island.nodes()[i].impulse[s];
    if (const springnet_status status = accelerate(island); status != SPRINGNET_OK) return status;
    find_slips(island);
    begin_slips(island);
    // Rounding of forces beside what was asked: those of stiff springs cancel.
    double forces = 0.0;
    for (const ContactNode& each : island.nodes())
      forces = std::max(forces, engine_.mass_[each.node] * each.acceleration.norm());
    const double negligible = least_force * engine_.info_.force_scale + 1e-12 * forces;
    if (island.resolve(negligible)) break;
    for (ContactNode& each : island.nodes()) std::fill(each.impulse.begin(), each.impulse.end(), Vector3::Zero());
    struck = jams < most_jams && island.jam(10.0 * no_speed_);
    if (!struck) {
      engine_.note_unresolved(node, time_);
      if (const springnet_status status = hold_on(island, negligible, blows); status != SPRINGNET_OK) return status;
      break;
    }
    for (const ContactNode& each : island.nodes())
      for (std::size_t s = 0; s < each.sides.size(); ++s)
        if (!each.impulse[s].isZero(0.0)) tell(Event::Kind::jammed, each.node, each.sides[s].surface, each.impulse[s]);
  }
  for (std::size_t i = 0; i < blows.size(); ++i) island.nodes()[i].impulse = blows[i];
  for (const ContactNode& each : island.nodes()) take(each);
  for (std::size_t i = 0; i < island.nodes().size(); ++i) {
    const ContactNode& each = island.nodes()[i];
    find_phase(each, island.acceleration(i), least_force * engine_.info_.force_scale / engine_.mass_[each.node]);
  }
  return SPRINGNET_OK;
}

springnet_status Engine::Settling::finish() {
  if (!struck_ && stopped_.empty()) return SPRINGNET_OK;
  engine_.changed();
  return engine_.constraints_.project(*at_, state_.view.position, state_.view.velocity, engine_.message_, stopped_,
                                      rebounds_);
}

}  // namespace springnet
