// Pairs of bodies that touch, as constraints of states and of their changes, where events are located.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "constraints/constraint_set.hpp"
#include "constraints/pair_motion.hpp"
#include "constraints/vectors.hpp"

namespace springnet {
namespace {

constexpr int most_corrections = 8;     // each squares the error, unless rows are nearly redundant
constexpr double rounding = 4e-16;      // of positions
constexpr double rounding_gaps = 32.0;  // times that, of the positions of a pair

}  // namespace

ConstraintRow row_along(const PairMotion& pair, const Vector3& direction) {
  ConstraintRow row{pair.nodes[0], pair.nodes[1], direction};
  if (pair.count > 2) row.third = pair.nodes[2];
  if (pair.count > 3) row.fourth = pair.nodes[3];
  row.weights = pair.weights;
  for (std::size_t i = pair.count; i < 4; ++i) row.weights[i] = 0.0;
  row.is_pair = true;
  return row;
}

std::vector<PairMotion> ConstraintSet::pairs_at(const springnet_const_vectors& position,
                                                const springnet_const_vectors& velocity) const {
  std::vector<PairMotion> result;
  for (const PairTouch& touch : bodies_.touching())
    result.push_back(pair_motion(bodies_, touch, position, velocity, mass_.size()));
  return result;
}

std::vector<ConstraintRow> ConstraintSet::rows_of(const std::vector<PairMotion>& pairs, bool with_sticking) const {
  std::vector<ConstraintRow> rows;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const PairMotion& pair = pairs[i];
    rows.push_back(row_along(pair, pair.normal));
    if (!with_sticking || !bodies_.touching()[i].sticks) continue;
    const Vector3 e = pair.normal.unitOrthogonal();
    rows.push_back(row_along(pair, e));
    rows.push_back(row_along(pair, pair.normal.cross(e)));
  }
  return rows;
}

// Newton's method on the gaps, then the rates; the obstacles under nodes of pairs take part, and the rigid connections
// of these, so that none undoes the other.
void ConstraintSet::project_pairs(const Placement& at, const springnet_vectors& position,
                                  const springnet_vectors& velocity) const {
  if (!bodies_.located() || bodies_.touching().empty()) return;
  std::set<std::uint32_t> clusters, on_obstacles;
  const auto add_obstacle = [&](std::uint32_t k) {
    if (contact_.now(k).slides && contact_.constrained()[k] == 0) on_obstacles.insert(k);
  };
  for (const PairMotion& pair : pairs_at(read_only(position), read_only(velocity)))
    for (std::size_t i = 0; i < pair.count; ++i) {
      add_obstacle(pair.nodes[i]);
      if (rigid_.is_joined(pair.nodes[i])) clusters.insert(rigid_.cluster_of()[pair.nodes[i]]);
    }
  for (const std::uint32_t cluster : clusters)
    for (const std::uint32_t k : rigid_.nodes_of(cluster)) add_obstacle(k);
  const auto mobility = [&](std::uint32_t node) -> Matrix3 {
    return contact_.constrained()[node] != 0 ? Matrix3(Matrix3::Zero()) : rigid_.mobility(node);
  };
  const auto add_obstacles = [&](std::vector<ConstraintRow>& rows) {
    for (const std::uint32_t k : on_obstacles)
      for (const std::int32_t surface : contact_.now(k).surfaces())
        if (surface >= 0)
          rows.push_back({k, ConstraintRow::no_node,
                          contact_.normal(at, static_cast<std::size_t>(surface), vector_at(position, k)), surface});
  };
  const auto add_rods = [&](std::vector<ConstraintRow>& rows) {
    for (const std::uint32_t cluster : clusters) rigid_.add_rows(cluster, read_only(position), rows);
  };
  ConstraintSystem system;
  const auto change = [](const springnet_vectors& values) {
    return [&values](std::uint32_t node, const Vector3& by) { put_vector(values, node, vector_at(values, node) + by); };
  };
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most_corrections; ++i) {
    const std::vector<PairMotion> pairs = pairs_at(read_only(position), read_only(velocity));
    std::vector<ConstraintRow> rows = rows_of(pairs, false);
    Eigen::VectorXd gaps(static_cast<Eigen::Index>(rows.size()));
    double greatest = 0.0, size = 0.0;
    for (std::size_t r = 0; r < pairs.size(); ++r) {
      const double gap = pairs[r].gap - bodies_.touching()[r].held_gap;
      gaps[static_cast<Eigen::Index>(r)] = gap;
      greatest = std::max(greatest, std::abs(gap));
      for (std::size_t j = 0; j < pairs[r].count; ++j)
        size = std::max(size, vector_at(position, pairs[r].nodes[j]).norm());
    }
    if (greatest <= rounding_gaps * rounding * size || greatest > 0.5 * last) break;
    last = greatest;
    add_obstacles(rows);
    const std::size_t first_rod = rows.size();
    add_rods(rows);
    gaps.conservativeResize(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t r = pairs.size(); r < first_rod; ++r)
      gaps[static_cast<Eigen::Index>(r)] =
          contact_.gap(at, static_cast<std::size_t>(rows[r].surface), vector_at(position, rows[r].first));
    std::size_t r = first_rod;
    for (const std::uint32_t cluster : clusters)
      rigid_.for_each_stretch(cluster, read_only(position),
                              [&](double stretch) { gaps[static_cast<Eigen::Index>(r++)] = stretch; });
    system.set(std::move(rows), mobility);
    system.for_each_change(system.solve(-gaps), change(position));
  }
  std::vector<ConstraintRow> rows = rows_of(pairs_at(read_only(position), read_only(velocity)), true);
  add_obstacles(rows);
  add_rods(rows);
  system.set(std::move(rows), mobility);
  const auto rates = system.rates([&](std::uint32_t node) { return vector_at(velocity, node); },
                                  [&](const ConstraintRow& row) {
                                    return Contact::velocity(at, static_cast<std::size_t>(row.surface),
                                                             vector_at(position, row.first));
                                  });
  system.for_each_change(system.solve(-rates), change(velocity));
}

}  // namespace springnet
