// What rigid connections do to outputs that do not fit them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <springnet/network.hpp>

#include "inspection/linearised.hpp"

namespace springnet {

// u <- u - W G^T (G W G^T)^-1 G u for the nodes of one cluster, with W the inverse of their inertia.
class RigidProjection {
 public:
  // nodes: free ones of the cluster. inverse_root: [node of the network] 1 / sqrt(mass), 0 where fixed.
  RigidProjection(const Network& network, std::vector<NodeIndex> nodes, const std::vector<RigidIndex>& rigids,
                  const std::vector<double>& inverse_root);

  [[nodiscard]] const std::vector<NodeIndex>& nodes() const { return nodes_; }
  // Inverse inertia of the nodes, [node of the network], times their mass; null: the identity.
  void set_inverse_inertia(const std::vector<Block>* inverse);
  // u: 3 numbers for each node of the network, times the root of its mass.
  void apply(Eigen::VectorXd& u);

 private:
  std::vector<NodeIndex> nodes_;
  Eigen::SparseMatrix<double> directions_;                                       // G: rigid connections x 3 nodes
  Eigen::SparseMatrix<double> mobile_;                                           // W G^T
  std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>> factors_;  // of G W G^T
  Eigen::VectorXd local_, multipliers_;
};

}  // namespace springnet
