#include "simulation/contact_changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "constraints/pair_features.hpp"
#include "constraints/vectors.hpp"
#include "simulation/contact_notes.hpp"
#include "simulation/pair_events.hpp"
#include "simulation/settling.hpp"

namespace springnet {
namespace {

// In units of the length scale. A node deeper behind an obstacle crossed it unnoticed, for example twice within one
// step of the reference.
constexpr double penetration = 1e-9;
// A node deeper behind an obstacle that it touches has no room left.
constexpr double squeezed = 1e-7;
// Smaller changes of a prescribed velocity, in units of the velocity scale, belong to a smooth motion.
constexpr double no_jump = 1e-9;

// Pairs of bodies that something else has moved apart since they touched. (Steps of others leave gaps, too.)
void drop_parted(Model& model) {
  BodyContacts& bodies = model.constraints.bodies();
  const double most = std::max(gap_tolerance * bodies.least_thickness(), model.contact_tolerance());
  std::vector<PairTouch> touching = bodies.touching();
  std::erase_if(touching, [&](const PairTouch& touch) {
    // Not as if the features between which they touched went on beyond their borders.
    const PairMotion motion = pair_motion(bodies, touch.kind, touch.pair, read_only(model.state.view.position),
                                          read_only(model.state.view.velocity), model.node_count());
    if (motion.gap <= most) return false;
    record_pair(model, Event::Kind::parted, model.time, motion, read_only(model.state.view.position),
                first_velocity(motion, read_only(model.state.view.velocity)), Vector3::Zero());
    return true;
  });
  // Moved on over a border, they touch between others.
  const proximity::Positions x = positions_of(read_only(model.state.view.position), model.node_count());
  for (PairTouch& touch : touching) {
    const PairMotion motion = pair_motion(bodies, touch, read_only(model.state.view.position),
                                          read_only(model.state.view.velocity), model.node_count());
    if (before_border(bodies, touch, motion, x, model.contact_tolerance()) < 0.0) touch.between = 0;
  }
  bodies.set_touching(std::move(touching));
}

}  // namespace

// Considers nodes in contact, and nodes that lie on an obstacle and may be pushed into it.
springnet_status settle_contacts(Model& model) {
  const BodyContacts& bodies = model.constraints.bodies();
  if (model.contact.obstacles().empty() && !bodies.located()) return SPRINGNET_OK;
  const std::shared_ptr<const Placement> at = model.placement(model.time);
  const double tolerance = model.contact_tolerance();
  Findings findings;
  if (bodies.located()) {
    drop_parted(model);
    for (const PairTouch& touch : bodies.touching()) findings.pairs[touch.key()];
    for (const proximity::NearPair& near : pairs_apart_within(model, read_only(model.state.view.position), tolerance))
      findings.pairs[{near.kind, near.pair}];
  }
  for (std::uint32_t k = 0; k < model.node_count(); ++k) {
    if (model.contact.fixed()[k] != 0) continue;
    bool near = model.contact.committed(k).surface >= 0;
    for (std::size_t j = 0; j < model.contact.obstacles().size() && !near; ++j)
      near = model.contact.gap(*at, j, vector_at(model.state.view.position, k)) <= tolerance;
    if (near) findings.nodes[k];
  }
  return settle(model, model.time, model.state, findings);
}

springnet_status stop_penetration(Model& model) {
  const std::shared_ptr<const Placement> at = model.placement(model.time);
  Findings findings;
  for (std::size_t j = 0; j < model.contact.obstacles().size(); ++j) {
    const auto surface = static_cast<std::int32_t>(j);
    for (std::uint32_t k = 0; k < model.node_count(); ++k) {
      if (model.contact.constrained()[k] != 0 || model.contact.committed(k).has(surface)) continue;
      if (model.contact.gap(*at, j, vector_at(model.state.view.position, k)) >= -penetration * model.scales.length)
        continue;
      findings.nodes[k].touched.push_back(surface);
    }
  }
  return settle(model, model.time, model.state, findings);
}

std::set<std::uint32_t> follow_prescribed(Model& model) {
  std::set<std::uint32_t> affected;
  Contact& contact = model.contact;
  const Prescribed& prescribed = contact.prescribed();
  if (!prescribed.any()) return affected;
  const std::shared_ptr<const Placement> now = model.placement_now();
  const springnet_vectors &position = model.state.view.position, &velocity = model.state.view.velocity;
  const std::uint32_t* const clusters = model.rigid.cluster_of();
  for (std::uint32_t k = 0; k < model.node_count(); ++k) {
    if (!prescribed.moves(k)) continue;
    const Vector3 change = prescribed.velocity(now->motions, k) - vector_at(velocity, k);
    put_vector(position, k, prescribed.position(now->motions, k));
    put_vector(velocity, k, prescribed.velocity(now->motions, k));
    if (change.norm() <= no_jump * model.scales.velocity) continue;
    contact.add_impulse(k, model.mass[k] * change);
    if (clusters != nullptr && clusters[k] != ConstraintRow::no_node) affected.insert(clusters[k]);
  }
  for (const std::uint32_t cluster : affected) {
    const RigidConnections::WithoutContact rods(model.rigid, cluster, read_only(position));
    rods.pull_along(velocity,
                    [&](std::uint32_t fixed, const Vector3& impulse) { contact.add_impulse(fixed, -impulse); });
  }
  return affected;
}

Followed follow_jumps(Model& model, double from, bool leave_told) {
  const std::set<std::uint32_t> pulled = follow_prescribed(model);
  const Contact& contact = model.contact;
  const BodyContacts& bodies = model.constraints.bodies();
  if (contact.obstacles().empty() && !bodies.located()) return {SPRINGNET_OK, !pulled.empty()};
  const double length = model.time > from ? model.time - from : model.time_step;  // none before the first step
  const std::shared_ptr<const Placement> before = contact.at(just_before(model.time, length));
  const std::shared_ptr<const Placement> now = model.placement_now();
  const auto jumps = [&](std::size_t j, const Vector3& p) {
    if (leave_told && contact.obstacles()[j].told()) return false;
    return Contact::velocity(*before, j, p) != Contact::velocity(*now, j, p);
  };
  Findings findings;
  for (std::uint32_t k = 0; k < model.node_count(); ++k)
    for (const std::int32_t surface : contact.committed(k).surfaces())
      if (surface >= 0 && jumps(static_cast<std::size_t>(surface), vector_at(model.state.view.position, k)))
        findings.nodes[k];
  for (const PairTouch& touch : bodies.touching()) {
    const std::array<NodeIndex, 4> nodes = bodies.primitives().nodes_of(touch.kind, touch.pair);
    const auto is_moved = [&](NodeIndex k) { return contact.prescribed().moves(k); };
    if (bodies.located() && std::any_of(nodes.begin(), nodes.end(), is_moved)) findings.pairs[touch.key()];
  }
  for (const std::uint32_t cluster : pulled)
    for (const std::uint32_t k : model.rigid.nodes_of(cluster))
      if (contact.touching()[k] != 0) findings.nodes[k];
  return {settle(model, model.time, model.state, findings), !pulled.empty()};
}

void note_left_behind(Model& model, std::size_t first_event, double from, std::set<std::size_t>& noted) {
  const std::vector<Event>& events = model.journal.events();
  for (std::size_t e = first_event; e < events.size(); ++e) {
    const Event& event = events[e];
    if (event.kind != Event::Kind::released || event.surface < 0) continue;
    const auto j = static_cast<std::size_t>(event.surface);
    const Obstacle& surface = model.contact.obstacles()[j];
    if (!surface.looks_sampled() || surface.next_change(from) > model.time || !noted.insert(j).second) continue;
    model.journal.note(
        fmt::format("At {:g} s {} separates from node {}, and perhaps from others, because the velocity of its linear "
                    "table jumps there. Set interpolation = \"smooth\" if the table was sampled from a smooth motion.",
                    model.time, model.contact.name_of(j), event.index));
  }
}

springnet_status check_room(Model& model, double time, const State& state) {
  const std::vector<Obstacle>& surfaces = model.contact.obstacles();
  if (std::none_of(surfaces.begin(), surfaces.end(), [](const Obstacle& surface) { return surface.moves(); }))
    return SPRINGNET_OK;
  const std::shared_ptr<const Placement> at = model.placement(time);
  for (std::uint32_t k = 0; k < model.node_count(); ++k) {
    const Touch& touch = model.contact.now(k);
    if (model.contact.fixed()[k] != 0 || touch.surface < 0) continue;
    const Vector3 p = vector_at(state.view.position, k);
    bool behind = false;
    for (std::size_t j = 0; j < surfaces.size() && !behind; ++j) behind = model.contact.gap(*at, j, p) < 0.0;
    if (!behind) continue;
    const std::vector<std::int32_t> closed = model.contact.closed_around(*at, p, model.contact_tolerance());
    if (closed.empty()) continue;
    return no_place(model, k, closed, time);
  }
  return SPRINGNET_OK;
}

springnet_status find_squeezed(Model& model) {
  if (model.contact.obstacles().empty()) return SPRINGNET_OK;
  const std::shared_ptr<const Placement> at = model.placement(model.time);
  for (std::uint32_t k = 0; k < model.node_count(); ++k) {
    if (model.contact.fixed()[k] != 0 || model.contact.touching()[k] == 0) continue;
    double deepest = 0.0;
    std::vector<std::int32_t> surfaces;
    for (const std::int32_t surface : model.contact.committed(k).surfaces()) {
      if (surface < 0) continue;
      const auto j = static_cast<std::size_t>(surface);
      surfaces.push_back(surface);
      deepest = std::max(deepest, -model.contact.gap(*at, j, vector_at(model.state.view.position, k)));
    }
    if (deepest > squeezed * model.scales.length) return no_place(model, k, surfaces, model.time);
  }
  return SPRINGNET_OK;
}

}  // namespace springnet
