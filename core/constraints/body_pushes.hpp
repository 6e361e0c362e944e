// Impulses of bodies in contact on nodes, kept from sweep to sweep of a step: each sweep adds them to what the update
// rule makes of a node, before obstacles have their say.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include <springnet/sdk/plugin.h>
#include <springnet/network.hpp>

#include "constraints/obstacle.hpp"
#include "constraints/vectors.hpp"
#include "layers/linear/constraint_row.hpp"

namespace springnet {

class BodyPushes {
 public:
  [[nodiscard]] const std::vector<std::uint32_t>& nodes() const noexcept { return nodes_; }
  [[nodiscard]] const Vector3& impulse(std::uint32_t node) const { return impulse_[node]; }  // N s
  // For springnet_network, whose addresses must not change.
  [[nodiscard]] const std::vector<std::uint8_t>& pushed() const noexcept { return pushed_; }
  [[nodiscard]] const std::uint32_t& count() const noexcept { return count_; }

  // For linear systems: pairs that press, and stick, as they were at the end of the last sweep.
  [[nodiscard]] const std::vector<ConstraintRow>& rows() const noexcept { return rows_; }
  // Of pairs that slide, across their slips: friction turns with these.
  struct Drag {
    ConstraintRow row;
    double damping;  // N s/m
  };
  [[nodiscard]] const std::vector<Drag>& drags() const noexcept { return drags_; }
  void set_rows(std::vector<ConstraintRow> rows, std::vector<Drag> drags = {}) {
    rows_ = std::move(rows);
    drags_ = std::move(drags);
  }

  // With room for so many nodes, and no pushes.
  void resize(std::size_t node_count) {
    impulse_.assign(node_count, Vector3::Zero());
    pushed_.assign(node_count, 0);
    nodes_.clear();
    count_ = 0;
  }
  void clear() {
    for (const std::uint32_t k : nodes_) {
      impulse_[k].setZero();
      pushed_[k] = 0;
    }
    nodes_.clear();
    rows_.clear();
    drags_.clear();
    count_ = 0;
  }
  // Nodes of pairs stay among those pushed, without an impulse, too.
  void add_node(std::uint32_t node) {
    if (pushed_[node] != 0) return;
    pushed_[node] = SPRINGNET_NEAR;
    nodes_.push_back(node);
    ++count_;
  }
  // how: SPRINGNET_NEAR …
  void set(std::uint32_t node, const Vector3& impulse, std::uint8_t how) {
    impulse_[node] = impulse;
    pushed_[node] = how;
  }

  // Changes a node's outputs by its impulse.
  void apply(std::uint32_t node, const springnet_sweep& sweep, double mass) const {
    if (pushed_[node] == 0 || impulse_[node].isZero(0.0)) return;
    Vector3 change = impulse_[node] / mass;
    if (sweep.inertia != nullptr)
      change = Eigen::Map<const Matrix3>(sweep.inertia + 9 * std::size_t{node}).inverse() * impulse_[node];
    const double weight = sweep.time_constant * (sweep.theta > 0.0 ? sweep.theta : 1.0);
    put_vector(sweep.next_velocity, node, vector_at(sweep.next_velocity, node) + change);
    put_vector(sweep.next_position, node, vector_at(sweep.next_position, node) + weight * change);
  }

 private:
  std::vector<Vector3> impulse_;      // N s, [node]
  std::vector<std::uint8_t> pushed_;  // [node]
  std::vector<std::uint32_t> nodes_;
  std::vector<ConstraintRow> rows_;
  std::vector<Drag> drags_;
  std::uint32_t count_ = 0;
};

}  // namespace springnet
