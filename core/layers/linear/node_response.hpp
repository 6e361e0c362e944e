// Nodes on surfaces in a matrix-free system. What surfaces make of the acceleration that a node would have without them
// is a block C of 3 x 3 numbers for each, of rank 0 to 3: they hold it, let it slide, with friction or without. The
// system x = C K x + b, for these nodes with b in the range of C, becomes one of forces in the space T of what a node
// can do: with C = T L^T, columns of T orthonormal, and M the mass
//
//   L^T S x = M T^T b,   S = M (I - K) + E,   E = M (C^+T - L L^+ T T^T)
//
// E is zero where C is a projection. Residuals have no part that L does not see, and solutions none outside of T.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "layers/linear/node_range.hpp"

namespace springnet::layers {

struct NodeResponse {
  std::uint32_t node;
  Eigen::Matrix3d response;     // C
  Eigen::Matrix3d by_velocity;  // 1/s, of the acceleration, that friction adds along the slip
};

class NodeResponses {
 public:
  // Ascending by node, none of which is fixed or held.
  void set(const std::vector<NodeResponse>& responses);
  [[nodiscard]] bool any() const noexcept { return !nodes_.empty(); }
  // Whether S is as symmetric as without them.
  [[nodiscard]] bool symmetric() const noexcept { return symmetric_; }

  // Calls use(node, E / M, by_velocity) for each.
  template <class Use>
  void for_each_addition(const Use& use) const {
    for (const Own& own : nodes_) use(own.node, own.addition, own.by_velocity);
  }
  // Calls use(node, T T^T) for each.
  template <class Use>
  void for_each_range(const Use& use) const {
    for (const Own& own : nodes_) use(own.node, own.allowed);
  }
  // Calls use(node, D) with what preconditions residuals of each, T (L^T B T)^-1 L^T; block(node): B, of all that acts
  // on it. False if that cannot be inverted.
  template <class BlockOf, class Use>
  [[nodiscard]] bool for_each_inverse(const BlockOf& block, const Use& use) const {
    for (const Own& own : nodes_) {
      const std::optional<Eigen::Matrix3d> inverse = inverse_of(own, block(own.node));
      if (!inverse) return false;
      use(own.node, *inverse);
    }
    return true;
  }
  // In place, [node][4], of nodes within the range: forces whose part along T is b become those that L sees, residuals
  // lose what it does not see, changes what is outside of T.
  void take_right_side(NodeRange range, double* values) const { apply(&Own::right, range, values); }
  template <class Number>
  void see(NodeRange range, Number* values) const {
    apply(&Own::seen, range, values);
  }
  template <class Number>
  void allow(NodeRange range, Number* values) const {
    apply(&Own::allowed, range, values);
  }

 private:
  struct Own {
    std::uint32_t node;
    Eigen::Index rank;
    Eigen::Matrix3d t, l;                   // the first `rank` columns
    Eigen::Matrix3d right, seen, allowed;   // C^+T, L L^+, T T^T
    Eigen::Matrix3d addition, by_velocity;  // E / M
  };
  [[nodiscard]] static std::optional<Eigen::Matrix3d> inverse_of(const Own& own, const Eigen::Matrix3d& block);
  template <class Number>
  void apply(const Eigen::Matrix3d Own::*matrix, NodeRange range, Number* values) const {
    const auto is_before = [](const Own& own, std::size_t node) { return own.node < node; };
    auto own = std::lower_bound(nodes_.begin(), nodes_.end(), range.begin, is_before);
    for (; own != nodes_.end() && own->node < range.end; ++own) {
      Eigen::Map<Eigen::Matrix<Number, 3, 1>> value(values + 4 * std::size_t{own->node});
      value = ((*own.*matrix) * value.template cast<double>()).template cast<Number>().eval();
    }
  }

  std::vector<Own> nodes_;
  bool symmetric_ = true;
};

}  // namespace springnet::layers
