#include "simulation/body_motion.hpp"

#include <algorithm>
#include <utility>

#include "constraints/friction.hpp"
#include "constraints/island.hpp"
#include "constraints/vectors.hpp"
#include "profile/stage.hpp"
#include "simulation/body_groups.hpp"
#include "simulation/reactions_at.hpp"
#include "simulation/struck_clusters.hpp"

namespace springnet {
namespace {

// A node on obstacles, as the committed state has it.
ContactNode on_obstacles(const Model& model, const ReactionsAt& at, std::uint32_t node, const Vector3& acceleration) {
  const Contact& contact = model.contact;
  const Placement& placement = at.placement();
  const Touch touch = contact.committed(node);
  const Vector3 p = at.position(node), v = at.velocity(node);
  ContactNode result;
  result.node = node;
  result.acceleration = acceleration;
  result.sticks = !touch.slides;
  for (const std::int32_t surface : touch.surfaces()) {
    if (surface < 0) continue;
    const auto j = static_cast<std::size_t>(surface);
    ContactSide side;
    side.surface = surface;
    side.normal = contact.normal(placement, j, p);
    side.friction = bounded(contact.obstacles()[j].friction());
    side.velocity = v - Contact::velocity(placement, j, p);
    side.surface_acceleration = Contact::acceleration(placement, j, p);
    side.target_acceleration =
        side.normal.dot(side.surface_acceleration) - contact.bias_acceleration(placement, j, p, side.velocity);
    result.sides.push_back(side);
  }
  if (!touch.slides) return result;
  result.slip = contact.slip_direction(placement, node, static_cast<std::size_t>(touch.surface), p, v);
  result.slipping = true;
  result.slip_starting = contact.slip_phase(node) == Contact::Slip::starting;
  return result;
}

ContactNode of_pair(const Model& model, const PairTouch& touch, const PairMotion& motion, const Vector3& acceleration) {
  ContactNode result;
  result.node = motion.nodes[0];
  result.pair = 0;
  result.acceleration = acceleration;
  result.sticks = touch.sticks;
  ContactSide side;
  side.normal = motion.normal;
  side.friction = bounded(model.constraints.bodies().law_of(touch.kind, touch.pair).friction);
  side.velocity = motion.velocity;
  side.target_acceleration = -motion.bias;
  result.sides.push_back(side);
  if (touch.sticks) return result;
  result.slip = slip_direction(model, touch, motion);
  result.slipping = true;
  result.slip_starting = touch.phase == Contact::Slip::starting;
  return result;
}

}  // namespace

springnet_status BodyMotion::find(Model& model, ReactionsAt& at) {
  const profile::Part part("bodies");
  const BodyContacts& bodies = model.constraints.bodies();
  pairs_.clear();
  nodes_.clear();
  std::vector<PairMotion> motions;
  for (const PairTouch& touch : bodies.touching())
    motions.push_back(pair_motion(bodies, touch, at.all_positions(), at.all_velocities(), model.node_count()));
  std::map<std::uint32_t, Vector3> free;
  std::vector<std::uint32_t> all;
  for (const PairMotion& motion : motions)
    for (std::size_t i = 0; i < motion.count; ++i) all.push_back(motion.nodes[i]);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  StruckClusters clusters(model);
  clusters.set(all, at.all_positions());
  clusters.add_nodes(all);
  if (const springnet_status status = at.prepare(all); status != SPRINGNET_OK) return status;
  for (const std::uint32_t k : all) {
    Vector3 acceleration;
    if (const springnet_status status = at.unsupported(k, acceleration); status != SPRINGNET_OK) return status;
    free[k] = acceleration;
    nodes_[k].acceleration = acceleration;
  }
  for (const auto& [number, rods] : clusters.clusters()) {
    const std::vector<std::uint32_t>& joined = model.rigid.nodes_of(number);
    std::vector<Vector3> accelerations;
    for (const std::uint32_t k : joined) accelerations.push_back(free.at(k));
    rods.accelerate(at.all_positions(), at.all_velocities(), accelerations);
    for (std::size_t i = 0; i < joined.size(); ++i) free[joined[i]] = nodes_[joined[i]].acceleration = accelerations[i];
  }
  const auto free_of = [&](std::uint32_t k) -> const Vector3& { return free.at(k); };
  std::vector<Vector3> forces(motions.size(), Vector3::Zero());
  std::vector<double> pressing(motions.size(), 0.0);
  for (const BodyGroup& group : body_groups(model, motions)) {
    std::vector<ContactNode> contacts;
    std::vector<Lever> levers;
    for (const std::uint32_t k : group.nodes) {
      if (model.contact.committed(k).surface < 0) continue;
      contacts.push_back(on_obstacles(model, at, k, free.at(k)));
      levers.emplace_back(k);
    }
    const std::size_t first_pair = contacts.size();
    for (const std::size_t i : group.pairs) {
      contacts.push_back(of_pair(model, bodies.touching()[i], motions[i], motions[i].relative(free_of)));
      levers.emplace_back(motions[i]);
    }
    Island island(std::move(contacts), mobility_of(model, levers, clusters));
    island.solve(true);
    std::map<std::uint32_t, Vector3> on_clusters;  // N
    for (std::size_t i = 0; i < levers.size(); ++i) {
      const ContactNode& contact = island.nodes()[i];
      levers[i].for_each([&](std::uint32_t k, double weight) {
        OfNode& node = nodes_[k];
        (i < first_pair ? node.reaction : node.pushed) += weight * contact.force;
        if (model.rigid.is_joined(k))
          on_clusters.try_emplace(k, Vector3::Zero()).first->second += weight * contact.force;
        else if (model.contact.fixed()[k] == 0)
          node.acceleration += weight / model.mass[k] * contact.force;
      });
      if (i < first_pair) continue;
      forces[group.pairs[i - first_pair]] = contact.force;
      pressing[group.pairs[i - first_pair]] = contact.normal_force[0];
    }
    clusters.spread(
        on_clusters, [this](std::uint32_t k, const Vector3& by) { nodes_[k].acceleration += by; },
        [](std::uint32_t, const Vector3&) {});  // what fixes nodes of clusters bears: see ReactionsAt
  }
  // What fixes a node bears all that acts on it, and gives it the acceleration that it has.
  for (auto& [k, node] : nodes_) {
    if (model.contact.fixed()[k] == 0 || model.rigid.is_joined(k)) continue;
    Vector3 without;
    if (const springnet_status status = at.unfixed(k, without); status != SPRINGNET_OK) return status;
    node.reaction = model.mass[k] * (node.acceleration - without) - node.pushed;
  }
  const auto bound_of = [&](std::uint32_t k) -> const Vector3& { return nodes_.at(k).acceleration; };
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Vector3 acceleration = motions[i].relative(bound_of);
    pairs_.push_back({std::move(motions[i]), forces[i], pressing[i], acceleration});
  }
  return SPRINGNET_OK;
}

}  // namespace springnet
