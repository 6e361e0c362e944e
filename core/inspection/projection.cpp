#include "inspection/projection.hpp"

#include <algorithm>
#include <utility>

namespace springnet {

RigidProjection::RigidProjection(const Network& network, std::vector<NodeIndex> nodes,
                                 const std::vector<RigidIndex>& rigids, const std::vector<double>& inverse_root)
    : nodes_(std::move(nodes)) {
  std::vector<std::pair<NodeIndex, int>> column;  // by node
  for (std::size_t i = 0; i < nodes_.size(); ++i) column.emplace_back(nodes_[i], static_cast<int>(3 * i));
  const auto column_of = [&](NodeIndex node) {
    const auto found = std::lower_bound(column.begin(), column.end(), std::pair{node, 0});
    return found != column.end() && found->first == node ? found->second : -1;
  };
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t row = 0; row < rigids.size(); ++row) {
    const Rigid& rigid = network.rigids()[rigids[row]];
    const Vector3 direction =
        (network.nodes()[rigid.first].position - network.nodes()[rigid.second].position) / rigid.length;
    for (const auto& [node, sign] : {std::pair{rigid.first, 1.0}, std::pair{rigid.second, -1.0}}) {
      const int at = column_of(node);
      if (at < 0) continue;
      for (int c = 0; c < 3; ++c) {
        entries.emplace_back(static_cast<int>(row), at + c, sign * inverse_root[node] * direction[c]);
      }
    }
  }
  directions_.resize(static_cast<Eigen::Index>(rigids.size()), static_cast<Eigen::Index>(3 * nodes_.size()));
  directions_.setFromTriplets(entries.begin(), entries.end());
  local_.resize(directions_.cols());
  set_inverse_inertia(nullptr);
}

void RigidProjection::set_inverse_inertia(const std::vector<Block>* inverse) {
  mobile_ = directions_.transpose();
  if (inverse != nullptr) {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          entries.emplace_back(static_cast<int>(3 * i) + r, static_cast<int>(3 * i) + c, (*inverse)[nodes_[i]](r, c));
        }
      }
    }
    Eigen::SparseMatrix<double> weights(directions_.cols(), directions_.cols());
    weights.setFromTriplets(entries.begin(), entries.end());
    mobile_ = weights * mobile_;
  }
  Eigen::SparseMatrix<double> matrix = directions_ * mobile_;
  // Redundant connections make it singular. So much on the diagonal changes no multiplier that does anything by more
  // than a few millionths of a millionth.
  const double shift = 1e-13 * matrix.diagonal().maxCoeff();
  for (Eigen::Index k = 0; k < matrix.rows(); ++k) {
    matrix.coeffRef(k, k) += shift > 0.0 ? shift : 1.0;  // 1: all nodes are fixed
  }
  factors_ = std::make_unique<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>(matrix);
}

void RigidProjection::apply(Eigen::VectorXd& u) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    local_.segment<3>(static_cast<Eigen::Index>(3 * i)) = u.segment<3>(3 * static_cast<Eigen::Index>(nodes_[i]));
  }
  multipliers_ = factors_->solve(directions_ * local_);
  local_ -= mobile_ * multipliers_;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    u.segment<3>(3 * static_cast<Eigen::Index>(nodes_[i])) = local_.segment<3>(static_cast<Eigen::Index>(3 * i));
  }
}

}  // namespace springnet
