#include "constraints/pair_motion.hpp"

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "constraints/least_squares.hpp"

namespace springnet {
namespace {

struct Wandering {
  std::size_t from, to;  // nodes of the pair
  Vector3 edge;          // m
};

// The edges of one primitive, its nodes [begin, end), along which its closest point can wander: between nodes that
// have weights.
void add_edges(const PairMotion& motion, const std::array<Vector3, 4>& x, std::size_t begin, std::size_t end,
               std::vector<Wandering>& edges) {
  std::size_t heaviest = begin;
  for (std::size_t i = begin; i < end; ++i)
    if (std::abs(motion.weights[i]) > std::abs(motion.weights[heaviest])) heaviest = i;
  for (std::size_t i = begin; i < end; ++i)
    if (i != heaviest && motion.weights[i] != 0.0) edges.push_back({heaviest, i, x[i] - x[heaviest]});
}

// Parallel edges, and triangles without area, do not determine how their closest points wander.
constexpr double singular = 1e-9;

}  // namespace

PairMotion pair_motion(const BodyContacts& bodies, proximity::PairKind kind, proximity::Pair pair,
                       const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                       std::size_t node_count, proximity::Features between) {
  const proximity::Primitives& all = bodies.primitives();
  const std::array<Vector3, 4> x = all.corners(kind, pair, positions_of(position, node_count));
  const proximity::Separation at = between == 0 ? separation(kind, x) : separation_between(kind, x, between);
  PairMotion result;
  result.kind = kind;
  result.pair = pair;
  result.nodes = all.nodes_of(kind, pair);
  result.weights = at.weights;
  const auto firsts = static_cast<std::size_t>(proximity::first_nodes(kind));
  result.count = firsts + static_cast<std::size_t>(proximity::second_nodes(kind));
  result.normal = at.direction;
  result.gap = at.distance - all.thickness(kind, pair);
  std::array<Vector3, 4> v;
  for (std::size_t i = 0; i < 4; ++i) v[i] = vector_at(velocity, result.nodes[i]);
  result.velocity = Vector3::Zero();
  for (std::size_t i = 0; i < result.count; ++i) result.velocity += at.weights[i] * v[i];
  if (!(at.distance > 0.0)) return result;
  std::vector<Wandering> edges;
  add_edges(result, x, 0, firsts, edges);
  add_edges(result, x, firsts, result.count, edges);
  const Vector3 d = at.distance * at.direction;
  const auto count = static_cast<Eigen::Index>(edges.size());
  Vector3 change = result.velocity;  // d'
  double wandering = 0.0;            // n.(sum w_i' v_i)
  if (count > 0) {
    Eigen::MatrixXd matrix(count, count);
    Eigen::VectorXd right(count);
    for (Eigen::Index j = 0; j < count; ++j) {
      const Wandering& row = edges[static_cast<std::size_t>(j)];
      right[j] = -(result.velocity.dot(row.edge) + d.dot(v[row.to] - v[row.from]));
      for (Eigen::Index l = 0; l < count; ++l) matrix(j, l) = row.edge.dot(edges[static_cast<std::size_t>(l)].edge);
    }
    const Eigen::VectorXd rates = least_squares(matrix, right, singular);
    for (Eigen::Index l = 0; l < count; ++l) {
      const Wandering& edge = edges[static_cast<std::size_t>(l)];
      change += rates[l] * edge.edge;
      wandering += rates[l] * result.normal.dot(v[edge.to] - v[edge.from]);
    }
  }
  const Vector3 turning = (change - result.normal * result.normal.dot(change)) / at.distance;
  result.bias = turning.dot(result.velocity) + wandering;
  return result;
}

}  // namespace springnet
