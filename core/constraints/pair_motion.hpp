// A pair of bodies in contact, at a state: where the two are closest, and how fast these points move and turn.
//
//   gap = |d| - thickness,  d = sum w_i x_i,  d gap / dt = n.u,  u = sum w_i v_i,
//   d^2 gap / dt^2 = n.(sum w_i a_i) + bias,  bias = n'.u + n.(sum w_i' v_i)
//
// The closest points wander: with the edges E_j of both primitives along which they can, d.E_j = 0 at all times, so
// that
//   sum_l (E_j.E_l) t_l = -(u.E_j + d.E_j'),  d' = u + sum_l t_l E_l,
// where t_l changes the weights of the two ends of E_l.
#pragma once

#include <array>
#include <cstdint>

#include <springnet/sdk/plugin.h>

#include "constraints/body_contacts.hpp"
#include "constraints/vectors.hpp"
#include "layers/linear/constraint_row.hpp"

namespace springnet {

struct PairMotion {
  proximity::PairKind kind{};
  proximity::Pair pair{};
  std::array<std::uint32_t, 4> nodes{};
  std::array<double, 4> weights{};     // of the first primitive's nodes 1 in all, of the second's -1
  std::size_t count = 0;               // of the nodes
  Vector3 normal = Vector3::UnitX();   // unit, from the second to the first
  double gap = 0.0;                    // m
  Vector3 velocity = Vector3::Zero();  // m/s: u
  double bias = 0.0;                   // m/s^2

  // Of values at nodes: of(node).
  template <class Of>
  [[nodiscard]] Vector3 relative(const Of& of) const {
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = 0; i < count; ++i) sum += weights[i] * Vector3(of(nodes[i]));
    return sum;
  }
  // Of a vector, the part along the surfaces.
  [[nodiscard]] Vector3 along(const Vector3& vector) const { return vector - normal * normal.dot(vector); }
  [[nodiscard]] Vector3 slip() const { return along(velocity); }  // m/s
};

// Of a pair that is checked, at a state of `node_count` nodes. between: see proximity::separation_between; 0: wherever
// it is closest.
[[nodiscard]] PairMotion pair_motion(const BodyContacts& bodies, proximity::PairKind kind, proximity::Pair pair,
                                     const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                                     std::size_t node_count, proximity::Features between = 0);
// Of one that touches, between the features that it has touched at.
[[nodiscard]] inline PairMotion pair_motion(const BodyContacts& bodies, const PairTouch& touch,
                                            const springnet_const_vectors& position,
                                            const springnet_const_vectors& velocity, std::size_t node_count) {
  return pair_motion(bodies, touch.kind, touch.pair, position, velocity, node_count, touch.between);
}

// The row of its closest points, relative to each other, along a direction (unit).
[[nodiscard]] ConstraintRow row_along(const PairMotion& pair, const Vector3& direction);

}  // namespace springnet
