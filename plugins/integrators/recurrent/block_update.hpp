// A node's step to its own equilibrium, with the other nodes fixed.
//
// With w = theta h, the node's residual and its derivative are
//
//   r(U) = U - v* - w a(p* + w U, U),   B = I - w da/dv - w^2 da/dp     (3x3)
//
// and the step is U' = U - M^-1 r, P' = p* + w U', where M is B, or, where its symmetric part is not positive definite
// (a buckling spring, a law that softens), a positive definite matrix in its place. The fixed point r = 0 is that of
// the other rules, whatever M. -r m is the slope of the node's potential m |U - v*|^2 / 2 + E(P) where one exists: the
// step is shortened while the slope at its end shows that it went much too far (but not on the linearised network).
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <springnet/sdk/host.hpp>

#include "step.hpp"
#include "workspace.hpp"

namespace springnet::recurrent {

// Scratch memory of a rule with block updates.
struct BlockMemory {
  Columns acceleration;         // m/s^2, at candidates
  std::vector<double> inertia;  // kg, [node][3][3]; empty where nothing constrains the outputs
  void attach(const springnet_network& network);
};

// Residual and matrices of one node at state `at`, element i of a batch with derivatives.
struct NodeStep {
  using Block = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  // `constrained`: constraints place the node elsewhere than at p* + w U.
  NodeStep(const Step& step, const springnet_state& at, const springnet_node_batch& batch, std::uint32_t i,
           bool constrained = false);

  Eigen::Vector3d velocity;  // U, m/s
  Eigen::Vector3d residual;  // r, m/s
  Block matrix;              // B
  Block positive;            // its symmetric part, made positive definite
  bool definite;             // the symmetric part was positive definite
  bool finite;               // false: numbers are not finite, no matrices
};

class BlockUpdate {
 public:
  BlockUpdate(const sdk::Host& host, const Step& step, BlockMemory& memory) noexcept;

  // Sets the fields of a sweep that this update needs.
  void request(springnet_sweep& call) const noexcept;
  // Returns whether all new outputs are finite. From several threads, for different nodes.
  bool operator()(const springnet_node_batch& batch) const;

 private:
  using Vector = Eigen::Vector3d;

  bool update(const springnet_node_batch& batch, std::uint32_t i) const;
  // Whether rigid connections or a surface act on a node, or did in the last sweep.
  [[nodiscard]] bool is_partly_constrained(std::uint32_t node) const noexcept;
  void put(std::uint32_t node, const Vector& velocity) const noexcept;
  [[nodiscard]] Vector acceleration_at(std::uint32_t node) const;
  void search(std::uint32_t node, const Vector& start, const Vector& residual, const Vector& direction) const;

  const sdk::Host& host_;
  const Step& step_;
  BlockMemory& memory_;
  springnet_vectors position_, velocity_;  // outputs
  double weight_;                          // s
  bool constrained_, writes_inertia_;
};

}  // namespace springnet::recurrent
