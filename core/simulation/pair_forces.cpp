#include "simulation/pair_forces.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "constraints/cone_forces.hpp"
#include "constraints/friction.hpp"
#include "constraints/least_squares.hpp"
#include "constraints/pair_motion.hpp"
#include "simulation/body_groups.hpp"
#include "simulation/pair_ending.hpp"
#include "simulation/struck_clusters.hpp"

namespace springnet {
namespace {

constexpr std::size_t most_pairs = 20'000;  // of a group; a face of 1000 nodes on another has some 4000
constexpr std::size_t most_in_cluster = 100;
constexpr double little = 1e-6;    // share of a force
constexpr double most_turn = 0.1;  // of a normal while its force acts, rad

using Matrix = Eigen::SparseMatrix<double>;

// A force along a direction, N, of a pair of the group.
struct Unknown {
  std::size_t pair;
  Vector3 direction;
  double start;
};

struct Unknowns {
  std::vector<Unknown> all;
  std::vector<ForceCone> cones;
};

// slow: m/s, of slips that are none.
void add(std::size_t place, const PairMotion& motion, const Vector3& force, double coefficient, double slow,
         Unknowns& to) {
  const Vector3& n = motion.normal;
  const double pressing = n.dot(force), across = motion.along(force).norm();
  const Vector3 slip = motion.slip();
  const auto first = static_cast<Eigen::Index>(to.all.size());
  // Normals turn while a force acts: what hardly presses along that of now has no direction to keep, and stays as it
  // is.
  if (across > (most_turn + 2.0 * coefficient) * pressing) return;
  const bool is_held = coefficient >= friction_of_held;
  const bool sticks =
      coefficient > 0.0 && slip.norm() <= slow && (is_held || across <= (1.0 + little) * coefficient * pressing);
  to.cones.push_back({first, sticks && !is_held, sticks && !is_held ? coefficient : 0.0});
  if (!sticks) {
    // The normal turned a little since the force acted.
    Vector3 direction = n;
    if (pressing > 0.0)
      direction = force / pressing;
    else if (coefficient > 0.0 && !is_held && !slip.isZero(0.0))
      direction -= coefficient * slip.normalized();
    to.all.push_back({place, direction, pressing});
    return;
  }
  const Vector3 e = n.unitOrthogonal();
  for (const Vector3& direction : {n, e, Vector3(n.cross(e))})
    to.all.push_back({place, direction, direction.dot(force)});
}

// The rows of what the unknowns do: to each node that moves alone its force; to a cluster what makes it move.
class Resultants {
 public:
  Resultants(const Model& model, const std::vector<PairMotion>& motions, const Unknowns& unknowns)
      : model_(model), count_(unknowns.all.size()) {
    for (std::size_t u = 0; u < unknowns.all.size(); ++u) {
      const PairMotion& motion = motions[unknowns.all[u].pair];
      for (std::size_t i = 0; i < motion.count; ++i) {
        const std::uint32_t k = motion.nodes[i];
        if (model.contact.fixed()[k] == 0 && motion.weights[i] != 0.0)
          users_[k].push_back({u, motion.weights[i] * unknowns.all[u].direction});
      }
    }
  }
  // Empty: a cluster has too many nodes.
  [[nodiscard]] Matrix matrix(const StruckClusters& clusters) {
    std::map<std::uint32_t, std::vector<std::uint32_t>> struck;  // [cluster]
    for (const auto& [node, users] : users_) {
      if (model_.rigid.is_joined(node)) {
        struck[model_.rigid.cluster_of()[node]].push_back(node);
        continue;
      }
      for (const Use& use : users) add(rows_, use, Matrix3::Identity());
      rows_ += 3;
    }
    for (const auto& [number, nodes] : struck) {
      if (nodes.size() > most_in_cluster) return {};
      add_cluster(clusters.clusters().at(number).mobility(nodes), nodes);
    }
    Matrix result(rows_, static_cast<Eigen::Index>(count_));
    result.setFromTriplets(entries_.begin(), entries_.end());
    return result;
  }

 private:
  struct Use {
    std::size_t unknown;
    Vector3 force;  // of the unknown 1 N
  };
  void add(Eigen::Index row, const Use& use, const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 3>>& by) {
    const Eigen::VectorXd sums = by * use.force;
    for (Eigen::Index r = 0; r < sums.size(); ++r)
      if (sums[r] != 0.0) entries_.emplace_back(row + r, static_cast<Eigen::Index>(use.unknown), sums[r]);
  }
  static constexpr double singular = 1e-9;  // of pivots, in units of the greatest
  // An orthonormal row for each way in which the cluster can move.
  void add_cluster(const Eigen::MatrixXd& mobility, const std::vector<std::uint32_t>& nodes) {
    if (mobility.isZero(0.0)) return;
    const Solution parts = solve_least_squares(mobility, Eigen::VectorXd::Zero(mobility.rows()), singular);
    const Eigen::MatrixXd ways =
        parts.kernel.cols() > 0 ? parts.row_space : Eigen::MatrixXd::Identity(mobility.rows(), mobility.cols());
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (const Use& use : users_[nodes[i]])
        add(rows_, use, ways.middleRows<3>(static_cast<Eigen::Index>(3 * i)).transpose());
    rows_ += ways.cols();
  }

  const Model& model_;
  std::size_t count_;                                // of the unknowns
  std::map<std::uint32_t, std::vector<Use>> users_;  // [node]
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::Index rows_ = 0;
};

}  // namespace

std::vector<Vector3> smallest_pair_forces(const Model& model) {
  const BodyContacts& bodies = model.constraints.bodies();
  std::vector<Vector3> forces;
  for (const PairTouch& touch : bodies.touching()) forces.push_back(touch.force);
  if (forces.size() < 2 || bodies.located()) return forces;  // located: they are the smallest
  const springnet_const_vectors position = read_only(model.state.view.position),
                                velocity = read_only(model.state.view.velocity);
  std::vector<PairMotion> motions;
  for (const PairTouch& touch : bodies.touching())
    motions.push_back(pair_motion(bodies, touch, position, velocity, model.node_count()));
  double slow = model.no_speed();
  if (model.step_length > 0.0) slow = std::max(slow, 0.1 * PairTolerances(model).gap / model.step_length);
  for (const BodyGroup& group : body_groups(model, motions)) {
    if (group.pairs.size() < 2 || group.pairs.size() > most_pairs) continue;
    Unknowns unknowns;
    for (const std::size_t i : group.pairs) {
      const PairTouch& touch = bodies.touching()[i];
      const double coefficient = coefficient_of(bodies.law_of(touch.kind, touch.pair).friction);
      add(i, motions[i], forces[i], coefficient, slow, unknowns);
    }
    StruckClusters clusters(model);
    clusters.set(group.nodes, position);
    const Matrix resultants = Resultants(model, motions, unknowns).matrix(clusters);
    if (resultants.rows() == 0) continue;
    Eigen::VectorXd start(static_cast<Eigen::Index>(unknowns.all.size()));
    for (std::size_t u = 0; u < unknowns.all.size(); ++u) start[static_cast<Eigen::Index>(u)] = unknowns.all[u].start;
    const Eigen::VectorXd least = least_with_resultants(resultants, start, unknowns.cones);
    for (const Unknown& unknown : unknowns.all) forces[unknown.pair].setZero();
    for (std::size_t u = 0; u < unknowns.all.size(); ++u)
      forces[unknowns.all[u].pair] += least[static_cast<Eigen::Index>(u)] * unknowns.all[u].direction;
  }
  return forces;
}

}  // namespace springnet
