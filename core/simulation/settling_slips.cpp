// Slips: which nodes slip, and how slips begin and end.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "constraints/friction.hpp"
#include "constraints/vectors.hpp"
#include "simulation/settling.hpp"

namespace springnet {
namespace {

// Pairs that began to slip or stuck `many_slips` times, each within `soon_slipping` (in units of the time to move the
// length scale) of the time before, show that friction on several at nearly the same place has no unique answer.
constexpr int many_slips = 16;
constexpr double soon_slipping = 1e-4;

}  // namespace

void Settling::find_slips(Island& island) const {
  for (ContactNode& node : island.nodes()) {
    std::vector<Vector3> normals;
    const ContactSide* first = nullptr;
    double friction = 0.0;
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      ContactSide& side = node.sides[s];
      side.separating = side.normal.dot(side.velocity) > no_speed_;
      // A node that arrived and was stopped is in contact, even if no force presses it.
      const bool arrived = !node.impulse[s].isZero(0.0) && !is_known(node, side);
      side.active = !side.separating && (side.active || arrived);
      if (side.separating) continue;
      normals.push_back(side.normal);
      friction += coefficient_of(side.friction);
      if (first == nullptr) first = &side;
    }
    node.slipping = node.sticks = false;
    if (first == nullptr) continue;
    const Vector3 slip = split_reaction(normals, first->velocity).tangential;
    const bool has_ended = node.pair >= 0 && node.slip_ended;
    node.slipping = slip.norm() > (has_ended ? creep_ : no_speed_) && friction > 0.0;
    if (node.slipping) node.slip = slip.normalized();
    node.sticks = !node.slipping && friction > 0.0 && surfaces_move_alike(node, jump_);
    // Friction keeps its direction where the slip has no speed yet, or one that errors of integration change.
    if (node.pair >= 0) {
      keep_slip_of_pair(node, friction);
      continue;
    }
    if (!model_.contact.committed(node.node).slides || node.slip_ended || friction == 0.0) continue;
    const Contact::Slip phase = model_.contact.slip_phase(node.node);
    if (phase == Contact::Slip::ongoing || (phase == Contact::Slip::ending && !node.slipping)) continue;
    node.slip_starting = phase == Contact::Slip::starting;
    node.sticks = false;
    node.slip = model_.contact.slip(node.node);
  }
}

// Nodes that begin to slip do so along the force that held them until now.
void Settling::begin_slips(Island& island) const {
  const auto slips = [this](const ContactNode& node) {
    return node.sticks &&
           (node.pair < 0 ? finding(node.node).slips : candidates_[static_cast<std::size_t>(node.pair)].found.slips);
  };
  if (std::none_of(island.nodes().begin(), island.nodes().end(), slips)) return;
  island.solve();
  for (std::size_t i = 0; i < island.nodes().size(); ++i)
    if (slips(island.nodes()[i]) && !island.release_held(i)) island.begin_slip(i);
}

void Settling::set_slip(std::uint32_t node, const Vector3& direction, Contact::Slip phase) {
  Contact& contact = model_.contact;
  if (contact.slip_phase(node) != phase) model_.changed();  // other events end it
  contact.set_slip(node, direction, phase);
}

// A slip that is slow and becomes slower is about to end.
void Settling::find_phase(const ContactNode& node, const Vector3& acceleration, double negligible) {
  if (node.pair >= 0) return find_phase_of_pair(node, acceleration, negligible);
  Contact& contact = model_.contact;
  const std::uint32_t k = node.node;
  const Touch& touch = contact.committed(k);
  if (!touch.slides || !node.slipping || contact.slip_phase(k) == Contact::Slip::ending) return;
  const auto j = static_cast<std::size_t>(touch.surface);
  const Vector3 p = vector_at(state_.view.position, k);
  const Vector3 slip = contact.slip_vector(*at_, k, j, p, vector_at(state_.view.velocity, k));
  const double speed = slip.norm();
  if (speed > contact.rest_speed() && !node.slip_starting) return;
  const double grows = slip.dot(acceleration - Contact::acceleration(*at_, j, p));
  if (grows < -negligible * speed)
    keep_direction(k);
  else if (!node.slip_starting && speed <= 0.5 * contact.rest_speed())
    set_slip(k, slip / speed, Contact::Slip::starting);
}

// Friction keeps the direction in which it ends the whole slip s at one time T: s + T a = 0, with a the acceleration
// relative to the obstacle. That is its mean direction until then.
void Settling::keep_direction(std::uint32_t k) {
  Contact& contact = model_.contact;
  const Touch touch = contact.committed(k);
  const auto j = static_cast<std::size_t>(touch.surface);
  const Vector3 p = vector_at(state_.view.position, k), v = vector_at(state_.view.velocity, k);
  const Vector3 slip = contact.slip_vector(*at_, k, j, p, v);
  if (slip.isZero(0.0)) return;
  const Vector3 n = contact.normal(*at_, j, p), goes = slip.normalized();
  const auto keep = [&](const Vector3& direction) { set_slip(k, direction, Contact::Slip::ending); };
  keep(goes);
  if (touch.second >= 0 || model_.constraints.coefficient(k, j) >= friction_of_held) return;
  double slows = 0.0;
  const auto found = find_direction(n, goes, [&](const Vector3& against) {
    keep(against);
    ReactionsAt reactions(model_, time_, read_only(state_.view.position), read_only(state_.view.velocity));
    Vector3 a;
    if (reactions.constrained(k, a) != SPRINGNET_OK) return std::numeric_limits<double>::quiet_NaN();
    a -= Contact::acceleration(*at_, j, p);
    slows = -goes.dot(a);
    return n.dot(goes.cross(a));
  });
  // Otherwise the slip does not end, but passes by zero.
  keep(found && found->dot(goes) > 0.0 && slows > 0.0 ? *found : goes);
}

// Ends the slip of nodes that struck an obstacle whose friction is `held`, if it is slower than `slow` (m/s): an
// integration error, or the rest of rocking. Returns whether there was any.
bool Settling::stop_held(Island& island, double slow) const {
  for (ContactNode& node : island.nodes()) {
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      const ContactSide& side = node.sides[s];
      node.slip_ended =
          node.slip_ended || (!node.impulse[s].isZero(0.0) && coefficient_of(side.friction) >= friction_of_held &&
                              side.velocity.norm() <= slow);
    }
  }
  return island.end_slip(no_speed_);
}

bool Settling::flutters() {
  if (group_ == nullptr) return false;
  bool result = false;
  std::set<std::uint32_t> counted;
  for (const std::size_t i : group_->pairs) {
    const Candidate& pair = candidates_[i];
    if (!(pair.found.slips || pair.found.slip_ended) || !counted.insert(pair.motion.nodes[0]).second) continue;
    const double short_time = soon_slipping * model_.scales.length / model_.scales.velocity;
    result = model_.recent_slips.count(pair.motion.nodes[0], time_, short_time) >= many_slips || result;
  }
  return result;
}

springnet_status Settling::stop_and_stick(Island& island, double negligible, double slow,
                                          std::vector<std::vector<Vector3>>& impulses) {
  for (ContactNode& node : island.nodes()) {
    std::fill(node.impulse.begin(), node.impulse.end(), Vector3::Zero());
    node.slip_ended = std::any_of(node.sides.begin(), node.sides.end(), [&](const ContactSide& side) {
      const double mu = coefficient_of(side.friction);
      return side.active && mu > 0.0 && (mu >= friction_of_held || side.velocity.norm() <= slow);
    });
  }
  if (island.end_slip(no_speed_)) {
    apply_impulses(island);
    for (std::size_t i = 0; i < impulses.size(); ++i)
      for (std::size_t s = 0; s < impulses[i].size(); ++s) impulses[i][s] += island.nodes()[i].impulse[s];
    if (const springnet_status status = accelerate(island); status != SPRINGNET_OK) return status;
  }
  for (ContactNode& node : island.nodes()) {
    if (!node.slip_ended) continue;
    node.slipping = node.slip_starting = false;
    node.sticks = true;
  }
  island.hold(negligible);
  return SPRINGNET_OK;
}

}  // namespace springnet
