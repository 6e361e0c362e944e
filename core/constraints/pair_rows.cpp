#include "constraints/pair_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "constraints/pair_newton.hpp"
#include "constraints/vectors.hpp"

namespace springnet {

Vector3 relative(const PairRow& row, const springnet_vectors& values) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < row.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    sum += row.weights[k] * vector_at(values, row.nodes[k]);
  }
  return sum;
}

const OnObstacle* held_back(const PairRow& row, std::size_t i, const MovedNodes& nodes) {
  if (nodes.on_obstacles == nullptr) return nullptr;
  const auto found = nodes.on_obstacles->find(row.nodes[i]);
  if (found == nodes.on_obstacles->end() || row.weights[i] * row.normal.dot(found->second.normal) > 0.0) return nullptr;
  return &found->second;
}

namespace {

// At least the greatest mobility of a node in any direction, 1/kg.
double norm_of(std::uint32_t node, const MovedNodes& nodes) {
  return (*nodes.mobility)[node] > 0.0 ? (*nodes.blocks)[node].norm() : 0.0;
}

// 1/kg, of the pair in all directions, as far as its nodes have rigid connections: several may be in one cluster.
Matrix3 cluster_mobility(const PairRow& row, const MovedNodes& nodes) {
  Matrix3 sum = Matrix3::Zero();
  for (int i = 0; i < row.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const ClusterResponses::Place* const moved = nodes.in_cluster(row.nodes[k]);
    for (int j = 0; moved != nullptr && j < row.count; ++j) {
      const auto l = static_cast<std::size_t>(j);
      if (const ClusterResponses::Place* const struck = nodes.in_cluster(row.nodes[l]))
        sum += row.weights[k] * row.weights[l] * nodes.clusters->between(*moved, *struck);
    }
  }
  return sum;
}

void change_by(const Vector3& change, double lever, std::uint32_t node, const MovedNodes& nodes) {
  put_vector(nodes.velocity, node, vector_at(nodes.velocity, node) + change);
  if (lever > 0.0) put_vector(nodes.position, node, vector_at(nodes.position, node) + lever * change);
}

}  // namespace

bool set_mobility(PairRow& row, const MovedNodes& nodes) {
  row.mobility = row.across = 0.0;
  row.coupled = cluster_mobility(row, nodes);
  const bool is_coupled = !row.coupled.isZero(0.0);
  double in_clusters = 0.0;  // 1/kg, if they were alone
  for (int i = 0; i < row.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double square = row.weights[k] * row.weights[k];
    const double own = nodes.blocks == nullptr ? (*nodes.mobility)[row.nodes[k]] : norm_of(row.nodes[k], nodes);
    if (nodes.in_cluster(row.nodes[k]) != nullptr) {
      in_clusters += square * own;
      continue;
    }
    const OnObstacle* const on = held_back(row, k, nodes);
    if (on != nullptr && on->sticks) continue;
    const auto change_by_unit = [&](const Vector3& direction) {
      const Vector3 change = nodes.change(row.nodes[k], direction);
      return on == nullptr ? change : Vector3(change - on->normal * on->normal.dot(change));
    };
    row.mobility += square * row.normal.dot(change_by_unit(row.normal));
    row.across += square * own;
    for (Eigen::Index c = 0; is_coupled && c < 3; ++c) row.coupled.col(c) += square * change_by_unit(Vector3::Unit(c));
  }
  if (is_coupled) {
    row.mobility = row.normal.dot(row.coupled * row.normal);
    row.across = row.coupled.norm();
  }
  // What is pressed onto obstacles from both sides, or belongs to one rigid body, cannot be moved along its normal.
  // What constraints leave of a cluster's mobility then is rounding of what its nodes would have alone.
  return row.mobility > 1e-12 * row.across && row.mobility > 1e-9 * in_clusters;
}

void push(std::uint32_t node, const Vector3& impulse, double lever, const MovedNodes& nodes) {
  if (const ClusterResponses::Place* const place = nodes.in_cluster(node))
    nodes.clusters->for_each_change(
        *place, impulse, [&](std::uint32_t moved, const Vector3& change) { change_by(change, lever, moved, nodes); });
  else
    change_by(nodes.change(node, impulse), lever, node, nodes);
}

void apply(const PairRow& row, const Vector3& impulse, const MovedNodes& nodes) {
  for (int i = 0; i < row.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const std::uint32_t node = row.nodes[k];
    if (row.weights[k] * (*nodes.mobility)[node] == 0.0) continue;
    const OnObstacle* const on = held_back(row, k, nodes);
    if (on == nullptr) {
      push(node, row.weights[k] * impulse, row.lever, nodes);
    } else if (!on->sticks) {
      const Vector3 change = nodes.change(node, row.weights[k] * impulse);
      change_by(change - on->normal * on->normal.dot(change), row.lever, node, nodes);
    }
  }
}

namespace {

// The impulse of a row whose nodes turn with rigid bodies: friction then changes what presses, and the other way round,
// so that both are found together. rate: m/s, of the pair. missing: m/s, along the normal.
Vector3 coupled_impulse(PairRow& row, Vector3 rate, double missing, double most_friction) {
  constexpr int most = 50;
  constexpr double accuracy = 1e-12;
  const double friction = std::min(row.friction, most_friction);
  Vector3 impulse = row.impulse;
  const auto change = [&](const Vector3& by) {
    const Vector3 response = row.coupled * by;
    impulse += by;
    rate += response;
    missing -= row.normal.dot(response);
  };
  for (int i = 0; i < most; ++i) {
    const Vector3 before = impulse;
    const double pressing = row.normal.dot(impulse), along = std::max(row.least, pressing + missing / row.mobility);
    change((along - pressing) * row.normal);
    if (!row.keeps_across || !(along > 0.0)) {
      const Vector3 slip = rate - row.normal * row.normal.dot(rate), now = impulse - along * row.normal;
      Vector3 across = friction > 0.0 && along > 0.0 ? Vector3(now - slip / row.across) : Vector3(Vector3::Zero());
      across -= row.normal * row.normal.dot(across);
      const double size = across.norm(), limit = along > 0.0 ? friction * along : 0.0;
      row.slips = size > limit;
      if (size > limit) across *= limit / size;
      change(across - now);
    }
    if ((impulse - before).norm() <= accuracy * impulse.norm()) break;
  }
  return impulse;
}

// Iterations after which friction and what presses are found at once where rigid bodies turn, so that each changes the
// other: slower where pairs are redundant, but it converges where one after the other does not.
constexpr int patience_with_coupled = 300;
// What holds a rigid body that turns may have to pull it, so that no impulse fits: after so many iterations friction of
// such pairs is at most 1, as that of rigid bodies on obstacles.
constexpr int patience_with_held = 800;

// One Gauss-Seidel iteration over all rows. changes: [row] m, of a gap or of a slip. Returns the greatest of them.
double relax(std::vector<PairRow>& rows, const MovedNodes& nodes, double length, int iteration,
             std::vector<double>& changes) {
  const bool together = iteration >= patience_with_coupled;
  const double most_friction = iteration >= patience_with_held ? 1.0 : std::numeric_limits<double>::infinity();
  double greatest = 0.0;
  changes.assign(rows.size(), 0.0);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    PairRow& row = rows[r];
    if (row.is_done || row.is_blocked) continue;
    const Vector3 rate = relative(row, nodes.velocity) - row.ground;
    const double missing = row.by_rate ? -(row.value + row.normal.dot(rate))
                                       : -(row.value + row.normal.dot(relative(row, nodes.position))) / row.lever;
    const double before = row.normal.dot(row.impulse), along = std::max(row.least, before + missing / row.mobility);
    Vector3 impulse = along * row.normal;
    if (!row.keeps_across) row.slips = !(row.friction > 0.0 && along > 0.0);
    if (together && !row.coupled.isZero(0.0)) {
      impulse = coupled_impulse(row, rate, missing, most_friction);
    } else if (row.keeps_across && along > 0.0) {
      impulse += row.impulse - before * row.normal;
    } else if (row.friction > 0.0 && along > 0.0) {
      // What would end the slip, within the cone.
      const Vector3 slip = rate - row.normal * row.normal.dot(rate);
      Vector3 across = row.impulse - row.normal * before - slip / row.across;
      across -= row.normal * row.normal.dot(across);
      const double most = row.friction * along, size = across.norm();
      row.slips = size > most;
      impulse += size > most ? Vector3(across * (most / size)) : across;
    }
    const Vector3 change = impulse - row.impulse;
    if (change.isZero(0.0)) continue;
    row.impulse = impulse;
    apply(row, change, nodes);
    const double moves = row.by_rate ? length : row.lever;
    const double answer = row.coupled.isZero(0.0) ? row.mobility : row.across;
    changes[r] = change.norm() * answer * moves;
    greatest = std::max(greatest, changes[r]);
  }
  return greatest;
}

// m, of gaps: no iteration gets nearer.
double rounding_of(const std::vector<PairRow>& rows, const MovedNodes& nodes) {
  constexpr double share = 64.0 * std::numeric_limits<double>::epsilon();
  double greatest = 0.0;
  for (const PairRow& row : rows) {
    if (row.by_rate) continue;
    for (int i = 0; i < row.count; ++i) {
      const Vector3 p = vector_at(nodes.position, row.nodes[static_cast<std::size_t>(i)]);
      greatest = std::max(greatest, p.cwiseAbs().maxCoeff());
    }
  }
  return share * greatest;
}

}  // namespace

PairSolution solve(std::vector<PairRow>& rows, const MovedNodes& nodes, double length, const PairAccuracy& accuracy) {
  PairSolution found;
  std::vector<Vector3> before(rows.size()), along(rows.size(), Vector3::Zero());
  double last = 0.0;  // square of the step before
  std::vector<double> changes;
  std::optional<PairNewton> newton;
  double wanted = std::max(accuracy.wanted, rounding_of(rows, nodes));
  for (; found.iterations < accuracy.most; ++found.iterations) {
    if (found.iterations == patience_with_coupled || found.iterations == patience_with_held) last = 0.0;
    for (std::size_t r = 0; r < rows.size(); ++r) before[r] = rows[r].impulse;
    found.residual = relax(rows, nodes, length, found.iterations, changes);
    if (found.iterations == 0)
      wanted = std::max(wanted, std::min(accuracy.enough, accuracy.share_of_first * found.residual));
    if (found.residual <= (found.iterations < accuracy.patience ? wanted : std::max(wanted, accuracy.enough))) break;
    if (found.iterations + 1 == accuracy.most) continue;  // the last one has to be in the cones
    if (found.iterations >= accuracy.before_newton && found.iterations < patience_with_held) {
      if (!newton) newton.emplace(rows, nodes, length);
      if (newton->step(changes, wanted)) {
        last = 0.0;
        continue;
      }
    }
    // Steps add up along conjugate directions while they become shorter.
    double square = 0.0;
    for (std::size_t r = 0; r < rows.size(); ++r)
      square += rows[r].mobility * (rows[r].impulse - before[r]).squaredNorm();
    const double share = last > 0.0 ? square / last : 0.0;
    last = square;
    const bool restarts = share > 1.0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const Vector3 step = rows[r].impulse - before[r];
      const Vector3 more = restarts ? Vector3(Vector3::Zero()) : Vector3(share * along[r]);
      along[r] = more + step;
      if (more.isZero(0.0)) continue;
      rows[r].impulse += more;
      apply(rows[r], more, nodes);
    }
  }
  // Comparisons with what is not a number would take it for a solution.
  for (const PairRow& row : rows)
    if (!row.impulse.allFinite()) found.residual = std::numeric_limits<double>::infinity();
  return found;
}

}  // namespace springnet
