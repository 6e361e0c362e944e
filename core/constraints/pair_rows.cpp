#include "constraints/pair_rows.hpp"

#include <algorithm>
#include <cmath>

namespace springnet {

Vector3 relative(const PairRow& row, const springnet_vectors& values) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < row.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    sum += row.weights[k] * vector_at(values, row.nodes[k]);
  }
  return sum;
}

namespace {

// The obstacle that keeps a node from moving along the impulse of a row; null: none.
const OnObstacle* held_back(const PairRow& row, std::size_t i, const MovedNodes& nodes) {
  if (nodes.on_obstacles == nullptr) return nullptr;
  const auto found = nodes.on_obstacles->find(row.nodes[i]);
  if (found == nodes.on_obstacles->end() || row.weights[i] * row.normal.dot(found->second.normal) > 0.0) return nullptr;
  return &found->second;
}

// At least the greatest mobility of a node in any direction, 1/kg.
double norm_of(std::uint32_t node, const MovedNodes& nodes) {
  return (*nodes.mobility)[node] > 0.0 ? (*nodes.blocks)[node].norm() : 0.0;
}

}  // namespace

bool set_mobility(PairRow& row, const MovedNodes& nodes) {
  row.mobility = row.across = 0.0;
  for (int i = 0; i < row.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double square = row.weights[k] * row.weights[k];
    const OnObstacle* const on = held_back(row, k, nodes);
    if (on != nullptr && on->sticks) continue;
    Vector3 change = nodes.change(row.nodes[k], row.normal);
    if (on != nullptr) change -= on->normal * on->normal.dot(change);
    row.mobility += square * row.normal.dot(change);
    row.across += square * (nodes.blocks == nullptr ? (*nodes.mobility)[row.nodes[k]] : norm_of(row.nodes[k], nodes));
  }
  // What is pressed onto obstacles from both sides cannot be moved along its normal.
  return row.mobility > 1e-12 * row.across;
}

void apply(const PairRow& row, const Vector3& impulse, const MovedNodes& nodes) {
  for (int i = 0; i < row.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const std::uint32_t node = row.nodes[k];
    if (row.weights[k] * (*nodes.mobility)[node] == 0.0) continue;
    Vector3 change = nodes.change(node, row.weights[k] * impulse);
    if (const OnObstacle* const on = held_back(row, k, nodes); on != nullptr) {
      if (on->sticks) continue;
      change -= on->normal * on->normal.dot(change);
    }
    put_vector(nodes.velocity, node, vector_at(nodes.velocity, node) + change);
    if (row.lever > 0.0) put_vector(nodes.position, node, vector_at(nodes.position, node) + row.lever * change);
  }
}

namespace {

// One Gauss-Seidel iteration over all rows. Returns the greatest change of a gap or of a slip, m.
double relax(std::vector<PairRow>& rows, const MovedNodes& nodes, double length) {
  double greatest = 0.0;
  for (PairRow& row : rows) {
    if (row.is_done || row.is_blocked) continue;
    const Vector3 rate = relative(row, nodes.velocity) - row.ground;
    const double missing = row.by_rate ? -(row.value + row.normal.dot(rate))
                                       : -(row.value + row.normal.dot(relative(row, nodes.position))) / row.lever;
    const double before = row.normal.dot(row.impulse), along = std::max(row.least, before + missing / row.mobility);
    Vector3 impulse = along * row.normal;
    if (row.keeps_across && along > 0.0) {
      impulse += row.impulse - before * row.normal;
    } else if (row.friction > 0.0 && along > 0.0) {
      // What would end the slip, within the cone.
      const Vector3 slip = rate - row.normal * row.normal.dot(rate);
      Vector3 across = row.impulse - row.normal * before - slip / row.across;
      across -= row.normal * row.normal.dot(across);
      const double most = row.friction * along, size = across.norm();
      impulse += size > most ? Vector3(across * (most / size)) : across;
    }
    const Vector3 change = impulse - row.impulse;
    if (change.isZero(0.0)) continue;
    row.impulse = impulse;
    apply(row, change, nodes);
    const double moves = row.by_rate ? length : row.lever;
    greatest = std::max(greatest, change.norm() * row.mobility * moves);
  }
  return greatest;
}

}  // namespace

PairSolution solve(std::vector<PairRow>& rows, const MovedNodes& nodes, double length, const PairAccuracy& accuracy) {
  PairSolution found;
  std::vector<Vector3> before(rows.size()), along(rows.size(), Vector3::Zero());
  double last = 0.0;  // square of the step before
  for (; found.iterations < accuracy.most; ++found.iterations) {
    for (std::size_t r = 0; r < rows.size(); ++r) before[r] = rows[r].impulse;
    found.residual = relax(rows, nodes, length);
    if (found.residual <= (found.iterations < accuracy.patience ? accuracy.wanted : accuracy.enough)) break;
    if (found.iterations + 1 == accuracy.most) continue;  // the last one has to be in the cones
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
  return found;
}

}  // namespace springnet
