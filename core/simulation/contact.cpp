#include "simulation/contact.hpp"

#include <algorithm>

namespace springnet {
namespace {

// Of mind, within a step, after which a node is held.
constexpr std::uint8_t most_changes = 8;

Vector3 at(const springnet_const_vectors& v, std::uint32_t k) { return {v.x[k], v.y[k], v.z[k]}; }
Vector3 at(const springnet_vectors& v, std::uint32_t k) { return {v.x[k], v.y[k], v.z[k]}; }
void put(const springnet_vectors& v, std::uint32_t k, const Vector3& value) {
  v.x[k] = value[0];
  v.y[k] = value[1];
  v.z[k] = value[2];
}

}  // namespace

Contact::Contact(const Network& network, const std::vector<std::uint32_t>& user_number, const std::vector<double>& mass)
    : planes_(network.planes()), mass_(mass) {
  const std::size_t nodes = user_number.size();
  fixed_.resize(nodes);
  for (std::size_t k = 0; k < nodes; ++k) fixed_[k] = network.nodes()[user_number[k]].fixed ? 1 : 0;
  constrained_ = fixed_;
  held_flag_.assign(nodes, 0);
  plane_of_.assign(nodes, -1);
  if (!planes_.empty()) {
    next_plane_.assign(nodes, -1);
    last_plane_.assign(nodes, -1);
    changes_.assign(nodes, 0);
    place_.assign(nodes, Vector3::Zero());
    stayed_.assign(nodes, 0);
    impulse_.assign(nodes, Vector3::Zero());
    sweep_impulse_.assign(nodes, Vector3::Zero());
  }
}

Vector3 Contact::impulse(std::uint32_t node) const { return impulse_.empty() ? Vector3::Zero() : impulse_[node]; }

void Contact::set_fixed(std::uint32_t node, bool fixed) {
  fixed_[node] = fixed ? 1 : 0;
  if (fixed) release(node);
  constrained_[node] = fixed_[node] | held_flag_[node];
}

void Contact::hold(std::uint32_t node, std::int32_t plane, const Vector3& impulse) {
  plane_of_[node] = next_plane_[node] = plane;
  held_flag_[node] = plane >= 0 ? 1 : 0;
  constrained_[node] = fixed_[node] | held_flag_[node];
  impulse_[node] += impulse;
}

void Contact::release(std::uint32_t node) {
  if (planes_.empty()) return;
  hold(node, -1, Vector3::Zero());
}

void Contact::begin_step() {
  std::fill(changes_.begin(), changes_.end(), std::uint8_t{0});
  std::copy(held_flag_.begin(), held_flag_.begin() + static_cast<std::ptrdiff_t>(stayed_.size()), stayed_.begin());
}

// The rule is discontinuous: a node that touches stops, which changes the forces on it by what dampers did, so that it
// may not touch any more; then it moves, and touches. No state is a fixed point of that. After some changes of mind the
// node is held for the rest of the step, where it last touched; that is off by no more than it moves in a step.
bool Contact::undecided(std::uint32_t node, bool stays) {
  if (changes_[node] >= most_changes) return true;
  if ((stayed_[node] != 0) != stays) ++changes_[node];
  stayed_[node] = stays ? 1 : 0;
  return changes_[node] >= most_changes;
}

void Contact::constrain(std::uint32_t first, std::uint32_t count, const double* const force[3],
                        const springnet_const_vectors& start, const springnet_vectors& position,
                        const springnet_vectors& velocity) {
  for (std::uint32_t k = first; k < first + count; ++k) {
    if (fixed_[k] != 0) {
      put(position, k, at(start, k));
      put(velocity, k, Vector3::Zero());
      continue;
    }
    if (planes_.empty()) continue;
    sweep_impulse_[k].setZero();
    const std::int32_t plane = plane_of_[k];
    if (plane >= 0) {
      const std::uint32_t i = k - first;
      const Vector3 net(force[0][i], force[1][i], force[2][i]);
      const bool stays = planes_[static_cast<std::size_t>(plane)].normal.dot(net) <= 0.0;
      if (undecided(k, stays) || stays) {
        next_plane_[k] = plane;
        put(position, k, at(start, k));
        put(velocity, k, Vector3::Zero());
        continue;
      }
    }
    constrain_free(k, at(start, k), position, velocity);
  }
}

void Contact::constrain_free(std::uint32_t node, const Vector3& start, const springnet_vectors& position,
                             const springnet_vectors& velocity) {
  const Vector3 end = at(position, node);
  double earliest = 2.0;
  std::int32_t touched = -1;
  for (std::size_t j = 0; j < planes_.size(); ++j) {
    const double after = distance(j, end);
    if (after >= 0.0) continue;
    const double before = distance(j, start);
    const double share = before > 0.0 ? before / (before - after) : 0.0;
    if (share < earliest) {
      earliest = share;
      touched = static_cast<std::int32_t>(j);
    }
  }
  if (touched >= 0) last_plane_[node] = touched;
  // A node that was held and leaves its plane was counted where that was decided.
  const bool was_undecided = changes_[node] >= most_changes;
  if (plane_of_[node] < 0 && undecided(node, touched >= 0)) {
    const auto j = static_cast<std::size_t>(last_plane_[node]);
    if (!was_undecided)
      place_[node] = touched >= 0 ? Vector3(start + earliest * (end - start))
                                  : Vector3(end - distance(j, end) * planes_[j].normal);
    sweep_impulse_[node] = -mass_[node] * at(velocity, node);
    put(position, node, place_[node]);
    put(velocity, node, Vector3::Zero());
    next_plane_[node] = last_plane_[node];
    return;
  }
  next_plane_[node] = touched;
  if (touched < 0) return;
  // The touch is new unless the node lies on the surface already and its release failed.
  if (plane_of_[node] != touched) sweep_impulse_[node] = -mass_[node] * at(velocity, node);
  put(position, node, start + earliest * (end - start));
  put(velocity, node, Vector3::Zero());
}

void Contact::commit_sweep(std::vector<std::uint32_t>& touched, std::vector<std::uint32_t>& released) {
  if (planes_.empty()) return;
  for (std::uint32_t k = 0; k < plane_of_.size(); ++k) {
    if (fixed_[k] != 0 || next_plane_[k] == plane_of_[k]) continue;
    if (plane_of_[k] >= 0) released.push_back(k);
    if (next_plane_[k] >= 0) touched.push_back(k);
    hold(k, next_plane_[k], next_plane_[k] >= 0 ? sweep_impulse_[k] : Vector3::Zero());
  }
}

}  // namespace springnet
