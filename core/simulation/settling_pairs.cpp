// Pairs of bodies in the settling of contacts: each is as a node on one side, whose position and velocity are those of
// its closest points relative to each other.

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "constraints/friction.hpp"
#include "constraints/vectors.hpp"
#include "simulation/pair_events.hpp"
#include "simulation/settling.hpp"

namespace springnet {

void Settling::gather_candidates() {
  if (gathered_) return;
  gathered_ = true;
  BodyContacts& bodies = model_.constraints.bodies();
  if (!bodies.located()) return;
  for (const PairTouch& touch : bodies.touching()) {
    Candidate& each = candidates_.emplace_back();
    each.touch = touch;
    each.was = each.stays = true;
  }
  // Beyond the tolerance those that are as near as one that they may take over from.
  double widest = 0.0;  // m
  for (const PairTouch& touch : bodies.touching()) widest = std::max(widest, touch.held_gap);
  const auto may_take_over = [&](const proximity::NearPair& near) {
    return std::any_of(bodies.touching().begin(), bodies.touching().end(), [&](const PairTouch& touch) {
      const auto found = findings_.pairs.find(touch.key());
      if (found == findings_.pairs.end() || !found->second.at_border || near.gap > touch.held_gap + depth_)
        return false;
      const std::array<NodeIndex, 4> own = bodies.primitives().nodes_of(touch.kind, touch.pair),
                                     others = bodies.primitives().nodes_of(near.kind, near.pair);
      const bool share = std::find_first_of(own.begin(), own.end(), others.begin(), others.end()) != own.end();
      return share && bodies.touch_alike(touch.kind, touch.pair, near.kind, near.pair);
    });
  };
  for (const proximity::NearPair& near : pairs_apart_within(model_, read_only(state_.view.position), widest + depth_)) {
    if (near.gap > depth_ && !may_take_over(near)) continue;
    Candidate& each = candidates_.emplace_back();
    each.touch.kind = near.kind;
    each.touch.pair = near.pair;
  }
  for (Candidate& each : candidates_) {
    const auto found = findings_.pairs.find(each.touch.key());
    if (found != findings_.pairs.end()) each.found = found->second;
  }
  find_features();
  join_grooves();
  leave_out_said();
  std::vector<PairMotion> motions;
  for (const Candidate& each : candidates_) motions.push_back(each.motion);
  groups_ = body_groups(model_, motions);
  group_done_.assign(groups_.size(), 0);
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (const std::uint32_t k : groups_[g].nodes) group_of_[k] = g;
}

PairMotion Settling::motion_of(const Candidate& candidate) const {
  return pair_motion(model_.constraints.bodies(), candidate.touch, read_only(state_.view.position),
                     read_only(state_.view.velocity), model_.node_count());
}

springnet_status Settling::settle_pairs() {
  if (findings_.pairs.empty() && !gathered_) return SPRINGNET_OK;
  gather_candidates();
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const bool is_found = std::any_of(groups_[g].pairs.begin(), groups_[g].pairs.end(), [&](std::size_t i) {
      return candidates_[i].takes_over || findings_.pairs.contains(candidates_[i].touch.key());
    });
    if (!is_found) continue;
    if (const springnet_status status = settle(groups_[g].nodes.front()); status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

bool Settling::comes_back(const Candidate& pair, double speed) const {
  ReactionsAt reactions(model_, time_, read_only(state_.view.position), read_only(state_.view.velocity));
  bool known = true;
  const Vector3 acceleration = pair.motion.relative([&](std::uint32_t k) {
    Vector3 a = Vector3::Zero();
    const springnet_status status =
        model_.contact.fixed()[k] != 0 ? reactions.unsupported(k, a) : reactions.constrained(k, a);
    known = known && status == SPRINGNET_OK;
    return a;
  });
  const double grows = pair.motion.normal.dot(acceleration) + pair.motion.bias;
  return known && grows > 0.0 && speed * speed <= 2.0 * grows * uncertain * model_.scales.length;
}

void Settling::add_pairs(std::vector<ContactNode>& nodes) const {
  const BodyContacts& bodies = model_.constraints.bodies();
  for (const std::size_t i : group_->pairs) {
    const Candidate& pair = candidates_[i];
    const BodyContact& law = bodies.law_of(pair.touch.kind, pair.touch.pair);
    const PairMotion motion = motion_of(pair);
    ContactNode node;
    node.pair = static_cast<std::int32_t>(i);
    node.node = *std::find_if(motion.nodes.begin(), motion.nodes.end(),
                              [&](std::uint32_t k) { return model_.contact.fixed()[k] == 0; });
    ContactSide side;
    side.normal = motion.normal;
    side.friction = bounded(law.friction);
    side.restitution = law.restitution;
    side.velocity = motion.velocity;
    side.target_acceleration = -motion.bias;
    side.active = pair.was && !pair.found.released;
    const double speed = side.normal.dot(side.velocity);
    if (!pair.was) {
      if (speed > no_speed_) continue;
      if (speed < -no_speed_ && motion.gap > -shallow * model_.scales.length && comes_back(pair, speed)) continue;
    }
    // Integration errors along directions that the contact constrains.
    const double least = pair.was ? jump_ : no_speed_;
    if (std::abs(speed) <= least) side.velocity -= speed * side.normal;
    if (pair.was && pair.touch.sticks && motion.slip().norm() <= jump_) side.velocity -= motion.along(side.velocity);
    node.slid = pair.was && !pair.touch.sticks;
    node.slip_ended = pair.found.slip_ended && node.slid;
    node.sides.push_back(side);
    nodes.push_back(std::move(node));
  }
}

Eigen::MatrixXd Settling::mobility(const std::vector<ContactNode>& nodes) const {
  std::vector<Lever> levers;
  for (const ContactNode& node : nodes) {
    if (node.pair < 0)
      levers.emplace_back(node.node);
    else
      levers.emplace_back(candidates_[static_cast<std::size_t>(node.pair)].motion);
  }
  return mobility_of(model_, levers, clusters_);
}

void Settling::apply_impulse(const Candidate& pair, const Vector3& impulse) {
  if (impulse.isZero(0.0)) return;
  std::map<std::uint32_t, Vector3> impulses;
  Lever(pair.motion).for_each([&](std::uint32_t k, double weight) { impulses[k] = weight * impulse; });
  spread(impulses);
}

void Settling::displace(const Candidate& pair, const Vector3& push) {
  std::map<std::uint32_t, Vector3> pushes;
  Lever(pair.motion).for_each([&](std::uint32_t k, double weight) { pushes[k] = weight * push; });
  move(pushes);
}

void Settling::move(const std::map<std::uint32_t, Vector3>& pushes) {
  const springnet_vectors& position = state_.view.position;
  clusters_.spread(
      pushes, [&](std::uint32_t k, const Vector3& dp) { put_vector(position, k, vector_at(position, k) + dp); },
      [](std::uint32_t, const Vector3&) {});
}

// Pairs at nearly the same place overlap by different amounts, as positions are uncertain. The least motion that ends
// the overlaps leaves some apart; to close these as well would take a large one.
void Settling::push_apart(const Island& island, const Eigen::MatrixXd& response) {
  std::vector<ContactNode> nodes = island.nodes();
  double deepest = 0.0, size = 0.0;
  for (ContactNode& node : nodes) {
    const Vector3 p = vector_at(state_.view.position, node.node);
    size = std::max(size, p.norm());
    for (ContactSide& side : node.sides) {
      double gap = 0.0;
      if (node.pair < 0) {
        gap = model_.contact.gap(*at_, static_cast<std::size_t>(side.surface), p);
      } else {
        const Candidate& pair = candidates_[static_cast<std::size_t>(node.pair)];
        gap = motion_of(pair).gap;
        if (pair.stays) deepest = std::max(deepest, -gap);
      }
      side.velocity = gap * side.normal;  // m, in place of m/s
      side.friction = {Friction::Kind::none, 0.0};
      side.restitution = 0.0;
    }
  }
  const double rounding = 16.0 * std::numeric_limits<double>::epsilon() * size;
  const bool pushes = deepest > rounding;
  if (pushes) {
    constexpr int rounds = 1000;  // what is left is overlap, too, but held
    Island apart(std::move(nodes), response);
    apart.apply_impact(0.0, rounding, rounds);
    std::map<std::uint32_t, Vector3> all;  // kg m
    const auto add = [&](std::uint32_t k, const Vector3& push) {
      all.try_emplace(k, Vector3::Zero()).first->second += push;
    };
    for (const ContactNode& node : apart.nodes())
      for (const Vector3& push : node.impulse) {
        if (node.pair < 0)
          add(node.node, push);
        else
          Lever(candidates_[static_cast<std::size_t>(node.pair)].motion).for_each([&](std::uint32_t k, double weight) {
            add(k, weight * push);
          });
      }
    move(all);
  }
  for (const ContactNode& node : island.nodes()) {
    if (node.pair < 0) continue;
    Candidate& pair = candidates_[static_cast<std::size_t>(node.pair)];
    if (!pair.stays || (pair.was && !pushes)) continue;
    pair.motion = motion_of(pair);
    pair.touch.held_gap = std::abs(pair.motion.gap) > rounding ? pair.motion.gap : 0.0;
  }
}

bool Settling::is_known(const ContactNode& node, const ContactSide& side) const {
  return node.pair < 0 ? model_.contact.committed(node.node).has(side.surface)
                       : candidates_[static_cast<std::size_t>(node.pair)].was;
}

void Settling::keep_slip_of_pair(ContactNode& node, double friction) const {
  const Candidate& pair = candidates_[static_cast<std::size_t>(node.pair)];
  if (!pair.was || pair.touch.sticks || node.slip_ended || friction == 0.0) return;
  if (pair.touch.phase == Contact::Slip::ongoing || (pair.touch.phase == Contact::Slip::ending && !node.slipping))
    return;
  const Vector3 kept = pair.motion.along(pair.touch.slip);
  if (kept.isZero(0.0)) return;
  node.slip_starting = pair.touch.phase == Contact::Slip::starting;
  node.sticks = false;
  node.slip = kept.normalized();
}

void Settling::commit_pair(const ContactNode& node, const Vector3& came) {
  Candidate& pair = candidates_[static_cast<std::size_t>(node.pair)];
  const ContactSide& side = node.sides[0];
  const Vector3& impulse = node.impulse[0];
  pair.motion = motion_of(pair);
  // kg, along the normal; 0 where nothing can move. What connections hold leaves rounding of what its nodes have alone.
  const auto inertia = [&] {
    const Matrix3 responses = mobility_of(model_, {Lever(pair.motion)}, clusters_);
    const double response = pair.motion.normal.dot(responses * pair.motion.normal);
    double alone = 0.0;
    Lever(pair.motion).for_each([&](std::uint32_t k, double weight) {
      if (model_.contact.fixed()[k] == 0) alone += weight * weight / model_.mass[k];
    });
    return response > 1e-9 * alone ? 1.0 / response : 0.0;
  };
  const auto record = [&](Event::Kind kind, const Vector3& given = Vector3::Zero()) {
    record_pair(model_, kind, time_, pair.motion, read_only(state_.view.position), came, given);
  };
  if (!pair.was) {
    if (!side.active && impulse.isZero(0.0)) return;
    const bool pulls = side.normal.dot(impulse) < 0.0;  // impulses that end rocking are no impacts
    record(Event::Kind::met, pulls ? Vector3(Vector3::Zero()) : impulse);
    pair.stays = side.active;
    model_.changed();
    if (!side.active) {
      // Put it on the surface, so that its next touch crosses the tolerance again.
      record(Event::Kind::parted);
      displace(pair, -pair.motion.gap * inertia() * pair.motion.normal);
      return;
    }
  } else if (!side.active) {
    record(Event::Kind::parted);
    pair.stays = false;
    model_.changed();
    const double speed = pair.motion.normal.dot(pair.motion.velocity);
    // An integration error would make it touch again.
    if (!side.separating && std::abs(speed) <= jump_) apply_impulse(pair, -speed * inertia() * pair.motion.normal);
    return;
  }
  PairTouch& touch = pair.touch;
  const bool had_slip = pair.was && !touch.sticks && !pair.found.slip_ended;
  const bool known = touch.sticks || !touch.slip.isZero(0.0);  // not of pairs that steps left behind
  if (pair.was && pair.found.slip_ended) record(Event::Kind::stuck);
  if (pair.was && known && node.sticks == had_slip && coefficient_of(side.friction) > 0.0)
    record(node.sticks ? Event::Kind::stuck : Event::Kind::slipped);
  if (node.sticks != touch.sticks || pair.found.slip_ended || pair.found.slips) model_.changed();
  const Contact::Slip phase = touch.phase;
  const bool slid = pair.was && !touch.sticks;
  touch.sticks = node.sticks;
  touch.held = node.sticks && holds_;
  if (node.sticks) return;
  if (!node.slipping || node.slip_starting) {
    touch.slip = node.slip;
    touch.phase = Contact::Slip::starting;
  } else if (!slid || touch.phase != Contact::Slip::ending) {
    const Vector3 slip = pair.motion.slip();
    touch.slip = slip.isZero(0.0) ? node.slip : Vector3(slip.normalized());
    touch.phase = Contact::Slip::ongoing;
  }
  if (touch.phase != phase) model_.changed();  // other events end it
}

void Settling::find_phase_of_pair(const ContactNode& node, const Vector3& acceleration, double negligible) {
  Candidate& pair = candidates_[static_cast<std::size_t>(node.pair)];
  PairTouch& touch = pair.touch;
  if (!pair.stays || touch.sticks || !node.slipping || touch.phase == Contact::Slip::ending) return;
  const Vector3 slip = motion_of(pair).slip();
  const double speed = slip.norm(), rest = model_.contact.rest_speed();
  if ((speed > rest && !node.slip_starting) || speed == 0.0) return;
  const double grows = slip.dot(acceleration);
  const Contact::Slip phase = touch.phase;
  if (grows < -negligible * speed) {
    touch.slip = slip / speed;
    touch.phase = Contact::Slip::ending;
    pair.ends = true;
  } else if (!node.slip_starting && speed <= 0.5 * rest) {
    touch.slip = slip / speed;
    touch.phase = Contact::Slip::starting;
  }
  if (touch.phase != phase) model_.changed();
}

void Settling::put_pairs() {
  if (!gathered_ || !model_.constraints.bodies().located()) return;
  std::vector<PairTouch> touching;
  for (const Candidate& each : candidates_)
    if (each.stays) touching.push_back(each.touch);
  BodyContacts& bodies = model_.constraints.bodies();
  bodies.set_touching(std::move(touching));
  // Directions depend on the forces of all pairs.
  for (PairTouch& touch : bodies.touching())
    if (std::any_of(candidates_.begin(), candidates_.end(),
                    [&](const Candidate& each) { return each.ends && each.touch.key() == touch.key(); }))
      keep_direction_of_pair(model_, time_, state_, touch);
}

}  // namespace springnet
