// The second half of a step: velocities at its end, and the contacts from then on.

#include "simulation/verlet_contact.hpp"

#include <algorithm>
#include <cmath>

#include "constraints/vectors.hpp"

namespace springnet {
namespace {

constexpr int max_kick_turns = 40;  // rounds of friction and the slip that it acts against

}  // namespace

springnet_status VerletContact::kick(const springnet_sweep& step) {
  last_.clear();
  last_h_ = h_;
  kicked_ = true;
  for (Body& body : bodies_) {
    springnet_status status =
        evaluate_forces(body, step, until_, read_only(step.next_position), read_only(step.next_velocity));
    if (status == SPRINGNET_OK) status = kick(body, step.next_position, step.next_velocity);
    if (status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

springnet_status VerletContact::kick(Body& body, const springnet_vectors& position, const springnet_vectors& velocity) {
  std::optional<Rods> rods;
  for (const Member& m : body.members) put_vector(position, m.node, m.position);
  std::vector<Vector3> v;
  for (Member& m : body.members) {
    m.velocity = m.fixed ? m.place_velocity : Vector3(m.velocity + m.half);
    v.push_back(m.velocity);
  }
  if (body.cluster) {
    rods.emplace(model_.rigid, *body.cluster, read_only(position));
    rods->project(v);
    for (std::size_t i = 0; i < v.size(); ++i) body.members[i].velocity = v[i];
  }
  const double per_speed = 2.0 / h_;
  std::vector<ContactNode> nodes;
  bool arrives = false;
  for (const Toucher& toucher : body.touchers) {
    const Member& m = body.members[toucher.member];
    ContactNode node;
    node.node = m.node;
    node.acceleration = per_speed * m.velocity;
    for (const Side& of : toucher.sides) {
      if (!of.active) continue;
      ContactSide side = side_of(body, toucher, of);
      const auto j = static_cast<std::size_t>(of.surface);
      side.surface_acceleration = per_speed * Contact::velocity(*at_, j, m.position);
      side.target_acceleration = side.normal.dot(side.surface_acceleration);
      const double comes = -side.normal.dot(side.velocity);
      // It approaches faster than at the impact, because the force has acted since.
      if (of.is_new && of.came > 0.0 && comes > 0.0) {
        arrives = true;
        const double restitution = contact_.obstacles()[j].restitution();
        if (restitution * of.came > 2.0 * std::abs(comes - of.came)) side.restitution = restitution * of.came / comes;
      }
      node.sides.push_back(side);
    }
    const bool slides = toucher.slip.norm() > 0.0;
    node.sticks = has_friction(node) && (toucher.sticks || !slides);
    node.slipping = has_friction(node) && !node.sticks;
    if (slides) node.slip = toucher.slip;
    nodes.push_back(std::move(node));
  }
  const Eigen::MatrixXd answers = mobility(body, rods);
  Island island(std::move(nodes), answers);
  std::vector<Vector3> impulses(body.touchers.size(), Vector3::Zero());
  bool struck = false;
  const auto hit = [&] {
    struck = true;
    for (std::size_t i = 0; i < impulses.size(); ++i) {
      const Member& m = body.members[body.touchers[i].member];
      for (ContactSide& side : island.nodes()[i].sides)
        side.velocity = m.velocity - side.surface_acceleration / per_speed;
    }
    apply_impulses(island, body);
    for (ContactNode& node : island.nodes()) {
      node.force = per_speed * sum_of(node.impulse);
      for (ContactSide& side : node.sides) side.active = side.normal.dot(side.velocity) <= 10.0 * model_.no_speed();
      const ContactSide* acts = first_acting(node);
      const Vector3 slip = acts != nullptr ? along_surfaces(node, acts->velocity) : Vector3(Vector3::Zero());
      node.sticks = has_friction(node) && slip.norm() <= 10.0 * model_.no_speed();
      node.slip = slip.norm() > 0.0 ? Vector3(slip.normalized()) : node.slip;
    }
  };
  if (arrives) {
    hit();
  } else {
    std::vector<std::uint8_t> turned(body.touchers.size(), 0);
    bool again = true;
    for (int turn = 0; turn < max_kick_turns && again; ++turn) {
      again = false;
      if (!island.resolve(negligible(body), false)) {
        hit();
        break;
      }
      for (std::size_t i = 0; i < impulses.size(); ++i) {
        ContactNode& node = island.nodes()[i];
        const ContactSide* acts = first_acting(node);
        if (acts == nullptr || node.sticks || !has_friction(node)) continue;
        const Vector3 slip = along_surfaces(node, island.acceleration(i) - acts->surface_acceleration);
        if (!node.slipping || !(slip.norm() > 0.0)) continue;
        // Against the slip that is left: it has the direction of the slip without the node's own friction.
        const auto place = static_cast<Eigen::Index>(3 * i);
        const Vector3 rubbed = answers.block<3, 3>(place, place) * along_surfaces(node, node.force);
        const Vector3 goes = (slip - along_surfaces(node, rubbed)).normalized();
        if (turned[i] == 0 && !(goes.dot(slip) > 0.0)) {
          // Friction that would reverse the slip ends it.
          turned[i] = 1;
          node.slipping = false;
          node.sticks = true;
          again = true;
        } else {
          again = again || (goes - node.slip).norm() > 1e-14;
          node.slip = goes;
        }
      }
    }
  }
  for (std::size_t i = 0; i < impulses.size(); ++i) impulses[i] = island.nodes()[i].force / per_speed;
  push(body, rods, impulses);
  remember(island, struck, body);
  for (const Toucher& toucher : body.touchers)
    for (const Side& side : toucher.sides)
      if (body.cluster) last_[{body.nodes[toucher.member], side.surface}] = side.impulse;
  for (const Member& m : body.members) put_vector(velocity, m.node, m.velocity);
  commit_contacts(body, island, position, velocity);
  return SPRINGNET_OK;
}

void VerletContact::record_event(Event::Kind kind, std::uint32_t node, std::int32_t surface, const Model::NodeAt& state,
                                 const Vector3& impulse) {
  model_.record(kind, until_, node, surface, state, *at_, impulse);
  ++model_.revision;
  model_.stale.reactions = model_.stale.pair_forces = true;
}

// Contacts as they are at the end of the step.
void VerletContact::commit_contacts(const Body& body, const Island& island, const springnet_vectors& position,
                                    const springnet_vectors& velocity) {
  for (std::size_t i = 0; i < body.touchers.size(); ++i) {
    const Toucher& toucher = body.touchers[i];
    const ContactNode& node = island.nodes()[i];
    const std::uint32_t k = node.node;
    const Touch before = contact_.committed(k);
    Touch now = before;
    // Within the step a node flies with the velocity in its middle until it meets the obstacle.
    const Member& member = body.members[toucher.member];
    const Model::NodeAt state{vector_at(position, k), member.start_velocity + member.half};
    std::size_t acting = 0;  // place among the island's sides
    std::vector<const Side*> arrived;
    std::vector<const ContactSide*> hit;
    std::vector<Vector3> impulses;
    for (const Side& side : toucher.sides) {
      const std::size_t s = acting;
      if (side.active) ++acting;
      const bool stays = side.active && node.sides[s].active;
      if (!side.is_new && !stays) {
        now = after(now, {ContactCause::Kind::release, side.surface});
        record_event(Event::Kind::released, k, side.surface, state);
      }
      if (!side.is_new) continue;
      arrived.push_back(&side);
      hit.push_back(stays ? &node.sides[s] : nullptr);
      impulses.emplace_back(side.arrival + (side.active ? node.impulse[s] : Vector3(Vector3::Zero())));
    }
    const bool stays = now.surface >= 0;
    Vector3 given = Vector3::Zero();
    for (std::size_t s = 0; s < arrived.size(); ++s) {
      const std::int32_t surface = arrived[s]->surface;
      record_event(Event::Kind::touched, k, surface, state, impulses[s]);
      given += impulses[s];
      contact_.add_surface_impulse(static_cast<std::size_t>(surface), -impulses[s]);
      if (hit[s] != nullptr)
        now = after(now, {ContactCause::Kind::touch, surface, node.sticks});
      else
        record_event(Event::Kind::released, k, surface, state);
    }
    const bool taken_along = node.sticks && surfaces_move_alike(node, 10.0 * model_.no_speed());
    now = after(now, {taken_along ? ContactCause::Kind::stick : ContactCause::Kind::slip});
    if (stays && now.slides != before.slides)
      record_event(now.slides ? Event::Kind::slipped : Event::Kind::stuck, k, now.surface, state);
    contact_.touch(k, now, given);
    if (now.surface < 0) continue;
    const auto j = static_cast<std::size_t>(now.surface);
    if (!now.slides) {
      // Free of rounding; but one that slid within the step has come to rest elsewhere.
      if (toucher.sticks && !before.slides && before.surface == now.surface)
        put_vector(position, k, contact_.carried(*at_, member.start, now.surface));
      put_vector(velocity, k, Contact::velocity(*at_, j, vector_at(position, k)));
      continue;
    }
    if (!body.cluster) contact_.project_sliding(*at_, k, position, velocity);
    if (node.slip.norm() > 0.0) contact_.set_slip(k, node.slip);
  }
}

}  // namespace springnet
