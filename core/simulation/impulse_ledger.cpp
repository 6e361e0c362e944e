#include "simulation/impulse_ledger.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "constraints/island.hpp"
#include "constraints/vectors.hpp"

namespace springnet {

springnet_status ImpulseLedger::begin_step() {
  // Drop what was withheld from nodes released since the last step.
  for (std::uint32_t k = 0; k < withheld_.size(); ++k)
    if (model_.contact.touching()[k] == 0) withheld_[k].setZero();
  return begin_anchored();
}

std::vector<Vector3> ImpulseLedger::book_contact(std::uint32_t node, const std::vector<std::int32_t>& surfaces,
                                                 const Placement& at, const Vector3& impulse) {
  model_.contact.add_impulse(node, impulse);
  std::vector<Vector3> normals;
  std::vector<double> coefficients;
  for (const std::int32_t surface : surfaces) {
    const auto j = static_cast<std::size_t>(surface);
    normals.push_back(model_.contact.normal(at, j, vector_at(model_.state.view.position, node)));
    coefficients.push_back(sliding_coefficient_of(model_.contact.obstacles()[j].friction()));
  }
  std::vector<Vector3> shares = share_reaction(normals, coefficients, impulse);
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    model_.contact.add_surface_impulse(static_cast<std::size_t>(surfaces[i]), -shares[i]);
  return shares;
}

void ImpulseLedger::book_motion(std::uint32_t node, const Placement& end) {
  const Prescribed& prescribed = model_.contact.prescribed();
  const Prescribed::Samples &before = model_.contact.start().motions, &after = end.motions;
  model_.contact.add_impulse(node,
                             model_.mass[node] * (prescribed.velocity(after, node) - prescribed.velocity(before, node) -
                                                  done_.rest * prescribed.acceleration(before, node) -
                                                  done_.weight * prescribed.acceleration(after, node)));
}

springnet_status ImpulseLedger::begin_anchored() {
  anchored_.clear();
  const bool books = !model_.contact.obstacles().empty() || model_.contact.prescribed().any();
  if (!books || model_.step_length == 0.0) return SPRINGNET_OK;
  std::optional<ReactionsAt> reactions;
  for (std::size_t c = 0; c < model_.rigid.cluster_count(); ++c) {
    const std::vector<std::uint32_t>& nodes = model_.rigid.nodes_of(c);
    if (std::none_of(nodes.begin(), nodes.end(), [this](std::uint32_t k) { return model_.contact.fixed()[k] != 0; }))
      continue;
    if (!reactions)
      reactions.emplace(model_, model_.time, read_only(model_.state.view.position),
                        read_only(model_.state.view.velocity));
    if (const springnet_status status = reactions->know(static_cast<std::uint32_t>(c)); status != SPRINGNET_OK)
      return status;
    AnchoredCluster& anchored = anchored_.emplace_back(AnchoredCluster{c, {}, {}});
    for (const std::uint32_t k : nodes) {
      anchored.velocity.push_back(vector_at(model_.state.view.velocity, k));
      anchored.acceleration.push_back(reactions->constrained(k));
    }
  }
  return SPRINGNET_OK;
}

springnet_status ImpulseLedger::book_anchored(const AnchoredCluster& anchored, ReactionsAt& reactions) {
  const std::vector<std::uint32_t>& nodes = model_.rigid.nodes_of(anchored.cluster);
  if (const springnet_status status = reactions.know(static_cast<std::uint32_t>(anchored.cluster));
      status != SPRINGNET_OK)
    return status;
  std::vector<Vector3> impulses;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::uint32_t k = nodes[i];
    const Vector3 change = vector_at(model_.state.view.velocity, k) - anchored.velocity[i];
    impulses.emplace_back(model_.mass[k] *
                              (change - done_.rest * anchored.acceleration[i] - done_.weight * reactions.free(k)) -
                          model_.contact.sweep_impulse(k));
  }
  model_.rigid.find_fixed_impulses(anchored.cluster, read_only(model_.state.view.position), impulses);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (model_.contact.fixed()[nodes[i]] == 0) continue;
    model_.contact.add_impulse(
        nodes[i], done_.weight * model_.rigid.connection_force(nodes[i], read_only(model_.state.view.position),
                                                               reactions.tensions().data()) -
                      impulses[i]);
  }
  return SPRINGNET_OK;
}

// What surfaces balance of the impulse of bodies on a node, with the sign of a reaction, N s: forces of bodies are part
// of what surfaces are reported to exert, and no impulse besides.
Vector3 ImpulseLedger::own_part_of_push(std::uint32_t node, const Placement& at) const {
  const BodyPushes& pushes = model_.constraints.pushes();
  if (pushes.count() == 0 || pushes.pushed()[node] == 0) return Vector3::Zero();
  if (model_.rigid.is_joined(node)) return Vector3::Zero();  // reactions of its cluster include them
  const Vector3 push = pushes.impulse(node);
  if (!model_.contact.committed(node).slides) return -push;
  const std::vector<Vector3> normals = model_.contact.normals(at, node, vector_at(model_.state.view.position, node));
  return split_reaction(normals, push).tangential - push;
}

// Pushes on one node of a cluster reach the obstacles of the others: they are part of its reactions. N.
std::map<std::uint32_t, Vector3> ImpulseLedger::pushes_on_clusters() const {
  std::map<std::uint32_t, Vector3> result;
  if (!(done_.weight > 0.0)) return result;
  const BodyPushes& pushes = model_.constraints.pushes();
  for (const std::uint32_t k : pushes.nodes())
    if (model_.rigid.is_joined(k)) result[k] = pushes.impulse(k) / done_.weight;
  return result;
}

springnet_status ImpulseLedger::commit(const Sweep::Done& done, const State& before) {
  done_ = done;
  const double time = model_.time;
  const bool surfaces_exist = !model_.contact.obstacles().empty();
  if (!surfaces_exist && !model_.contact.prescribed().any()) return SPRINGNET_OK;
  using Kind = ContactChange::Kind;
  // After a step decides all slips are ongoing ones, which other events end than those that were beginning or ending.
  bool is_phase_left = false;
  for (std::uint32_t k = 0; k < model_.node_count() && surfaces_exist && done_.decided; ++k)
    is_phase_left = is_phase_left || model_.contact.slip_phase(k) != Contact::Slip::ongoing;
  const std::vector<ContactChange> changes = model_.contact.commit_sweep(done_.decided);
  if (!changes.empty() || is_phase_left) ++model_.revision;
  const auto by_node = [](const ContactChange& a, const ContactChange& b) { return a.node < b.node; };
  std::vector<ContactChange> sorted = changes;
  std::stable_sort(sorted.begin(), sorted.end(), by_node);
  const std::shared_ptr<const Placement> at = model_.placement(time);
  const std::size_t count = model_.node_count();
  withheld_.resize(count, Vector3::Zero());
  std::vector<Vector3> impulses(count, Vector3::Zero());
  std::map<std::pair<std::uint32_t, std::int32_t>, Vector3> impacts;  // [node, surface] N s
  std::optional<ReactionsAt> known;
  const auto reactions = [&]() -> ReactionsAt& {
    if (!known) {
      known.emplace(model_, time, read_only(model_.state.view.position), read_only(model_.state.view.velocity));
      known->add_forces(pushes_on_clusters());
    }
    return *known;
  };
  std::vector<std::uint32_t> touching;
  for (std::uint32_t k = 0; surfaces_exist && k < count; ++k)
    if (model_.contact.fixed()[k] == 0 && model_.contact.committed(k).surface >= 0) touching.push_back(k);
  if (!touching.empty())
    if (const springnet_status status = reactions().prepare(std::move(touching)); status != SPRINGNET_OK) return status;
  for (std::uint32_t k = 0; k < count; ++k) {
    if (model_.contact.fixed()[k] != 0) {
      withheld_[k].setZero();
      if (model_.contact.prescribed().moves(k)) book_motion(k, *at);
      continue;
    }
    if (!surfaces_exist) continue;
    impulses[k] = model_.contact.sweep_impulse(k) + done_.rest * withheld_[k];
    withheld_[k].setZero();
    std::vector<std::int32_t> surfaces;
    for (const std::int32_t surface : model_.contact.committed(k).surfaces())
      if (surface >= 0) surfaces.push_back(surface);
    if (!surfaces.empty()) {
      Vector3 reaction;
      if (const springnet_status status = reactions().reported(k, reaction, &withheld_[k]); status != SPRINGNET_OK)
        return status;
      impulses[k] -= done_.weight * reaction + own_part_of_push(k, *at);
    }
    if (impulses[k].isZero(0.0)) continue;
    const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), ContactChange{{}, k, -1}, by_node);
    for (auto change = first; change != last; ++change)
      if (surfaces.size() < 3 && std::find(surfaces.begin(), surfaces.end(), change->surface) == surfaces.end())
        surfaces.push_back(change->surface);
    if (surfaces.empty()) surfaces.push_back(std::max(0, model_.contact.last_surface(k)));
    const std::vector<Vector3> shares = book_contact(k, surfaces, *at, impulses[k]);
    for (std::size_t i = 0; i < surfaces.size() && first != last; ++i) impacts[{k, surfaces[i]}] = shares[i];
  }
  for (const AnchoredCluster& anchored : anchored_)
    if (const springnet_status status = book_anchored(anchored, reactions()); status != SPRINGNET_OK) return status;
  const auto record = [&](const ContactChange& change) {
    static constexpr Event::Kind kinds[] = {Event::Kind::touched, Event::Kind::released, Event::Kind::slipped,
                                            Event::Kind::stuck};
    // Where the step ends; the sweeps have no other velocity before the contact than that with which it began.
    const Model::NodeAt state{vector_at(model_.state.view.position, change.node),
                              vector_at(before.view.velocity, change.node)};
    Vector3 impulse = Vector3::Zero();
    // If the reaction at the end exceeds that over the step, or the error of the method outweighs the impact, the
    // difference is a pull: then the event has no impulse, but the node's sum of impulses still includes it.
    if (const auto impact = impacts.find({change.node, change.surface});
        change.kind == Kind::touched && impact != impacts.end() &&
        model_.contact
                .normal(*at, static_cast<std::size_t>(change.surface),
                        vector_at(model_.state.view.position, change.node))
                .dot(impact->second) >= 0.0)
      impulse = impact->second;
    model_.record(kinds[static_cast<std::size_t>(change.kind)], time, change.node, change.surface, state, *at, impulse);
  };
  for (const ContactChange& change : changes) record(change);
  model_.contact.update_slip_directions(*at, read_only(model_.state.view.position),
                                        read_only(model_.state.view.velocity));
  return SPRINGNET_OK;
}

}  // namespace springnet
