// The impulses of pairs in contact, all at once: no overlap, no pull, Coulomb's cone, by projected Gauss-Seidel
// iteration (J. J. Moreau 1988; M. Jean, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235), whose steps are combined
// as conjugate gradients do (M. Silcowitz-Hansen, S. Niebe, K. Erleben, The Visual Computer 26 (2010) 893): of a block
// on a block it alone needs tens of thousands, because faces against faces are redundant. Each row is a pair with
// four nodes at most; its impulse J on the first primitive is shared among its nodes by their weights, w_i J, so that
// momentum is kept whatever J is.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include <springnet/network.hpp>

#include "constraints/body_contacts.hpp"
#include "constraints/cluster_responses.hpp"
#include "constraints/obstacle.hpp"

namespace springnet {

struct PairRow {
  proximity::PairKind kind{};
  proximity::Pair pair{};
  std::array<std::uint32_t, 4> nodes{};
  std::array<double, 4> weights{};    // of the first primitive's nodes 1 in all, of the second's -1
  int count = 0;                      // of the nodes
  Vector3 normal = Vector3::UnitX();  // unit, from the second to the first
  Vector3 ground = Vector3::Zero();   // m/s, of a second that is no node
  double friction = 0.0;              // coefficient; infinite: held
  double lever = 0.0;                 // s: an impulse moves a node by this times its change of velocity
  // Its impulse is the least for which `value` + normal . (sum of weights times velocities) >= 0 where `by_rate`, else
  // `value` + normal . (sum of weights times positions) >= 0; m/s, m.
  bool by_rate = false;
  bool is_done = false;       // keeps its impulse
  bool is_blocked = false;    // likewise, as long as obstacles hold all of its nodes
  bool slips = false;         // friction does not stop it: as the last iteration found it
  bool keeps_across = false;  // keeps the part of its impulse across the normal, while it presses
  double least = 0.0;         // N s, along the normal: what it has given before
  double value = 0.0;
  Vector3 impulse = Vector3::Zero();  // N s
  double mobility = 0.0;              // 1/kg, of the pair along the normal
  double across = 0.0;                // 1/kg, and along each other, at most
  // 1/kg, of the pair in all directions, if some of its nodes have rigid connections; else zero
  Matrix3 coupled = Matrix3::Zero();
};

// What an obstacle lets a node on it do.
struct OnObstacle {
  Vector3 normal;  // unit, to the free side
  bool sticks;     // else it slides
};

// Velocities and positions of all nodes, which impulses change.
struct MovedNodes {
  springnet_vectors position, velocity;
  const std::vector<double>* mobility;  // [node] 1/kg; 0: it cannot move
  // [node] 1/kg, of nodes that can move: of an update whose effective masses have directions. Null: `mobility`.
  const std::vector<Matrix3>* blocks = nullptr;
  // [node] A pair pushes those that are on obstacles along them only, or not at all, unless it pushes them off. Null:
  // none is.
  const std::map<std::uint32_t, OnObstacle>* on_obstacles = nullptr;
  // Of nodes with rigid connections; their response includes their obstacles. Null: none has any.
  const ClusterResponses* clusters = nullptr;

  // Null: it moves alone.
  [[nodiscard]] const ClusterResponses::Place* in_cluster(std::uint32_t node) const {
    return clusters == nullptr ? nullptr : clusters->find(node);
  }
  // Of a node that moves alone: its change of velocity, m/s, by an impulse, N s.
  [[nodiscard]] Vector3 change(std::uint32_t node, const Vector3& impulse) const {
    const double own = (*mobility)[node];
    return blocks == nullptr || own == 0.0 ? Vector3(own * impulse) : Vector3((*blocks)[node] * impulse);
  }
};

[[nodiscard]] Vector3 relative(const PairRow& row, const springnet_vectors& values);
// The obstacle that keeps the i-th node of a row from moving along the impulse of that row; null: none.
[[nodiscard]] const OnObstacle* held_back(const PairRow& row, std::size_t i, const MovedNodes& nodes);
// Sets row.mobility and across. False if none of its nodes can move.
[[nodiscard]] bool set_mobility(PairRow& row, const MovedNodes& nodes);
// Changes the velocity of a node, and of those that it is rigidly connected to, by an impulse (N s), and positions by
// `lever` (s) times that.
void push(std::uint32_t node, const Vector3& impulse, double lever, const MovedNodes& nodes);
// Changes velocities and positions by an impulse (N s) of a row.
void apply(const PairRow& row, const Vector3& impulse, const MovedNodes& nodes);

struct PairSolution {
  double residual = 0.0;  // m: the greatest change of a gap or of a slip over the step in the last iteration
  int iterations = 0;
};
// How far iterations go: until the residual is at most `wanted`, or after `patience` of them `enough`, m; no more than
// `most`. Where the problem will change again, a share of its first residual may be wanted, too. From
// `before_newton` iterations on Newton's method takes part.
struct PairAccuracy {
  double wanted, enough;
  int patience, most;
  double share_of_first = 0.0;
  int before_newton = 60;
};
// Changes the impulses of all rows, from those that they have and that the nodes have moved with. length: of the step,
// s.
PairSolution solve(std::vector<PairRow>& rows, const MovedNodes& nodes, double length, const PairAccuracy& accuracy);

}  // namespace springnet
