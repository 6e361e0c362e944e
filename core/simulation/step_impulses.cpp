// What surfaces and fixation gave at once in a step of sweeps, so that momentum balances. Over the step each node has
//
//   m (v' - v) = h ((1 - theta) (F + R) + theta F') + J,
//
// F forces, R reactions at its start, primes at its end, J impulses of the sweeps. What is told of the surfaces' part
// of that as a force is h ((1 - theta) R + theta R'); the rest came at once: where a node touched that is the blow,
// else what a method of its order leaves. What holds or moves a node gets the same of the rigid connections that hang
// on it.

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "constraints/island.hpp"
#include "constraints/vectors.hpp"
#include "simulation/engine.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {

std::vector<Vector3> Engine::book_contact(std::uint32_t node, const std::vector<std::int32_t>& surfaces,
                                          const Placement& at, const Vector3& impulse) {
  contact_.add_impulse(node, impulse);
  std::vector<Vector3> normals;
  std::vector<double> coefficients;
  for (const std::int32_t surface : surfaces) {
    const auto j = static_cast<std::size_t>(surface);
    normals.push_back(contact_.normal(at, j, vector_at(state_.view.position, node)));
    coefficients.push_back(sliding_coefficient_of(contact_.surfaces()[j].friction()));
  }
  std::vector<Vector3> shares = share_reaction(normals, coefficients, impulse);
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    contact_.add_surface_impulse(static_cast<std::size_t>(surfaces[i]), -shares[i]);
  return shares;
}

// What moves a node gives it what its acceleration does not.
void Engine::book_motion(std::uint32_t node, const Placement& end) {
  const Prescribed& prescribed = contact_.prescribed();
  const Prescribed::Samples &before = contact_.start().motions, &after = end.motions;
  contact_.add_impulse(node, mass_[node] * (prescribed.velocity(after, node) - prescribed.velocity(before, node) -
                                            swept_rest_ * prescribed.acceleration(before, node) -
                                            swept_weight_ * prescribed.acceleration(after, node)));
}

springnet_status Engine::note_anchored() {
  anchored_.clear();
  const bool books = !contact_.surfaces().empty() || contact_.prescribed().any();
  if (!books || step_length_ == 0.0) return SPRINGNET_OK;
  std::optional<ReactionsAt> reactions;
  for (std::size_t c = 0; c < rigid_.cluster_count(); ++c) {
    const std::vector<std::uint32_t>& nodes = rigid_.nodes_of(c);
    if (std::none_of(nodes.begin(), nodes.end(), [this](std::uint32_t k) { return contact_.fixed()[k] != 0; }))
      continue;
    if (!reactions) reactions.emplace(*this, time_, read_only(state_.view.position), read_only(state_.view.velocity));
    if (const springnet_status status = reactions->know(static_cast<std::uint32_t>(c)); status != SPRINGNET_OK)
      return status;
    AnchoredCluster& anchored = anchored_.emplace_back(AnchoredCluster{c, {}, {}});
    for (const std::uint32_t k : nodes) {
      anchored.velocity.push_back(vector_at(state_.view.velocity, k));
      anchored.acceleration.push_back(reactions->bound(k));
    }
  }
  return SPRINGNET_OK;
}

// What connections gave the nodes that can move is what forces, reactions and surfaces did not; what holds the others
// bears the opposite of what they get.
springnet_status Engine::book_anchored(const AnchoredCluster& anchored, ReactionsAt& reactions) {
  const std::vector<std::uint32_t>& nodes = rigid_.nodes_of(anchored.cluster);
  if (const springnet_status status = reactions.know(static_cast<std::uint32_t>(anchored.cluster));
      status != SPRINGNET_OK)
    return status;
  std::vector<Vector3> impulses;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::uint32_t k = nodes[i];
    const Vector3 change = vector_at(state_.view.velocity, k) - anchored.velocity[i];
    impulses.emplace_back(mass_[k] *
                              (change - swept_rest_ * anchored.acceleration[i] - swept_weight_ * reactions.free(k)) -
                          contact_.sweep_impulse(k));
  }
  rigid_.find_fixed_impulses(anchored.cluster, read_only(state_.view.position), impulses);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (contact_.fixed()[nodes[i]] == 0) continue;
    contact_.add_impulse(nodes[i], swept_weight_ * rigid_.connection_force(nodes[i], read_only(state_.view.position),
                                                                           reactions.tensions().data()) -
                                       impulses[i]);
  }
  return SPRINGNET_OK;
}

springnet_status Engine::commit_sweeps(double time) {
  const bool surfaces_exist = !contact_.surfaces().empty();
  if (!surfaces_exist && !contact_.prescribed().any()) return SPRINGNET_OK;
  using Kind = ContactChange::Kind;
  const std::vector<ContactChange> changes = contact_.commit_sweep(swept_decided_);
  if (!changes.empty()) ++revision_;
  const auto by_node = [](const ContactChange& a, const ContactChange& b) { return a.node < b.node; };
  std::vector<ContactChange> sorted = changes;
  std::stable_sort(sorted.begin(), sorted.end(), by_node);
  const std::shared_ptr<const Placement> at = placement(time);
  const std::size_t count = layout_.node_count();
  withheld_.resize(count, Vector3::Zero());
  std::vector<Vector3> at_once(count, Vector3::Zero());
  std::map<std::pair<std::uint32_t, std::int32_t>, Vector3> blows;  // [node, surface] N s
  std::optional<ReactionsAt> known;
  const auto reactions = [&]() -> ReactionsAt& {
    if (!known) known.emplace(*this, time, read_only(state_.view.position), read_only(state_.view.velocity));
    return *known;
  };
  for (std::uint32_t k = 0; k < count; ++k) {
    if (contact_.fixed()[k] != 0) {
      withheld_[k].setZero();
      if (contact_.prescribed().moves(k)) book_motion(k, *at);
      continue;
    }
    if (!surfaces_exist) continue;
    at_once[k] = contact_.sweep_impulse(k) + swept_rest_ * withheld_[k];
    withheld_[k].setZero();
    std::vector<std::int32_t> surfaces;
    for (const std::int32_t surface : contact_.committed(k).surfaces())
      if (surface >= 0) surfaces.push_back(surface);
    if (!surfaces.empty()) {
      Vector3 reaction;
      if (const springnet_status status = reactions().told(k, reaction, &withheld_[k]); status != SPRINGNET_OK)
        return status;
      at_once[k] -= swept_weight_ * reaction;
    }
    if (at_once[k].isZero(0.0)) continue;
    const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), ContactChange{{}, k, -1}, by_node);
    for (auto change = first; change != last; ++change)
      if (surfaces.size() < 3 && std::find(surfaces.begin(), surfaces.end(), change->surface) == surfaces.end())
        surfaces.push_back(change->surface);
    if (surfaces.empty()) surfaces.push_back(std::max(0, contact_.last_surface(k)));
    const std::vector<Vector3> shares = book_contact(k, surfaces, *at, at_once[k]);
    for (std::size_t i = 0; i < surfaces.size() && first != last; ++i) blows[{k, surfaces[i]}] = shares[i];
  }
  for (const AnchoredCluster& anchored : anchored_)
    if (const springnet_status status = book_anchored(anchored, reactions()); status != SPRINGNET_OK) return status;
  const auto tell = [&](const ContactChange& change) {
    static constexpr Event::Kind kinds[] = {Event::Kind::touched, Event::Kind::released, Event::Kind::slipped,
                                            Event::Kind::stuck};
    Event event{kinds[static_cast<std::size_t>(change.kind)], time, layout_.ordering().user[change.node]};
    event.surface = change.surface;
    // The reaction at the end may be more than that over a step that it did not last, or a method's error outweigh the
    // blow: a surface never pulls, so that none is told then. The node's sum of impulses has what is missing.
    if (const auto blow = blows.find({change.node, change.surface});
        change.kind == Kind::touched && blow != blows.end() &&
        contact_.normal(*at, static_cast<std::size_t>(change.surface), vector_at(state_.view.position, change.node))
                .dot(blow->second) >= 0.0)
      event.impulse = blow->second;
    events_.push_back(event);
  };
  for (const ContactChange& change : changes) tell(change);
  contact_.note_slips(*at, read_only(state_.view.position), read_only(state_.view.velocity));
  return SPRINGNET_OK;
}

}  // namespace springnet
