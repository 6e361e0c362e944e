#include "inspection/vibration.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

#include "inspection/dominant.hpp"

namespace springnet {

namespace {

using Matrix = Eigen::SparseMatrix<double>;

// Motions without stiffness come before the first vibration; with more of them the search would take long.
constexpr std::size_t most_free_motions = 24;
// Of the greatest eigenvalue: keeps the factorisation regular, and is small beside that of a slow vibration (a beam of
// 100 cells has 1e-8).
constexpr double shift = 1e-10;

// Stiffness and damping in outputs times the root of the mass: symmetric, and the masses are gone.
class Matrices {
 public:
  Matrices(const Network& network, const LinearNetwork& linear) : column_(linear.nodes.size(), -1) {
    for (std::size_t k = 0; k < column_.size(); ++k) {
      root_.push_back(std::sqrt(network.nodes()[k].mass));
      if (!linear.nodes[k].free) continue;
      column_[k] = size_;
      size_ += 3;
    }
    for (std::size_t s = 0; s < linear.springs.size(); ++s) {
      const LinearSpring& spring = linear.springs[s];
      const Block along = spring.direction * spring.direction.transpose();
      const double across = spring.across_stiffness();
      const Block stiffness = (spring.stiffness - across) * along + across * Block::Identity();
      const Block damping = spring.axial_damping * along + spring.general_damping * Block::Identity();
      const NodeIndex ends[] = {network.springs()[s].first, network.springs()[s].second};
      for (const NodeIndex i : ends)
        for (const NodeIndex j : ends) add(i, j, i == j ? stiffness : -stiffness, i == j ? damping : -damping);
    }
    for (const LinearElement& element : linear.elements.all()) {
      for (std::size_t i = 0; i < element.nodes.size(); ++i)
        for (std::size_t j = 0; j < element.nodes.size(); ++j)
          add(element.nodes[i], element.nodes[j], element.blocks.stiffness[i][j], element.blocks.damping_block(i, j));
    }
    for (NodeIndex k = 0; k < column_.size(); ++k) {
      const double mass = network.nodes()[k].mass;
      add(k, k, -mass * linear.nodes[k].by_position, -mass * linear.nodes[k].by_velocity);
    }
  }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] Matrix stiffness() const { return matrix(stiffness_); }
  [[nodiscard]] Matrix damping() const { return matrix(damping_); }

 private:
  void add(NodeIndex i, NodeIndex j, const Block& stiffness, const Block& damping) {
    if (column_[i] < 0 || column_[j] < 0) return;
    const double weight = 1.0 / (root_[i] * root_[j]);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        stiffness_.emplace_back(column_[i] + a, column_[j] + b, weight * stiffness(a, b));
        damping_.emplace_back(column_[i] + a, column_[j] + b, weight * damping(a, b));
      }
  }
  [[nodiscard]] Matrix matrix(const std::vector<Eigen::Triplet<double>>& entries) const {
    Matrix result(size_, size_);
    result.setFromTriplets(entries.begin(), entries.end());
    return result;
  }

  std::vector<int> column_;
  std::vector<double> root_;  // [node], kg^(1/2)
  int size_ = 0;
  std::vector<Eigen::Triplet<double>> stiffness_, damping_;
};

// A neuron that is a mass, with a drag perhaps.
bool is_mass(const LinearNode& node, double mass) {
  return !node.free || (node.by_force - Block::Identity() / mass).norm() <= 1e-9 / mass;
}

bool is_within_reach(const Network& network, const LinearNetwork& linear, const Mobility& mobility) {
  if (!linear.unknown_because.empty() || !mobility.known || !network.rigids().empty()) return false;
  if (mobility.mechanisms + mobility.rigid_body_motions > most_free_motions) return false;
  for (const LinearElement& element : linear.elements.all()) {
    if (element.is_enclosure()) return false;
  }
  for (std::size_t k = 0; k < linear.nodes.size(); ++k) {
    if (!is_mass(linear.nodes[k], network.nodes()[k].mass)) return false;
  }
  return true;
}

}  // namespace

std::optional<Vibration> slowest_vibration(const Network& network, const LinearNetwork& linear,
                                           const Mobility& mobility) {
  if (!is_within_reach(network, linear, mobility)) return std::nullopt;
  const Matrices matrices(network, linear);
  const auto free_motions = static_cast<Eigen::Index>(mobility.mechanisms + mobility.rigid_body_motions);
  if (matrices.size() <= free_motions) return std::nullopt;
  const Matrix stiffness = matrices.stiffness();
  const double greatest = Eigen::VectorXd(stiffness.diagonal()).maxCoeff();
  if (!(greatest > 0.0) || !std::isfinite(greatest)) return std::nullopt;

  Matrix shifted = stiffness;
  for (int k = 0; k < matrices.size(); ++k) shifted.coeffRef(k, k) += shift * greatest;
  const Eigen::SimplicialLDLT<Matrix> factors(shifted);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0.0)) return std::nullopt;

  // Subspace iteration (Bathe): inverse iteration of several motions together, then the best in their span.
  constexpr Eigen::Index more = 8;
  constexpr int most_iterations = 40;
  constexpr double accuracy = 1e-3;
  const Eigen::Index size = matrices.size(), wanted = std::min(free_motions + more, size);
  Eigen::MatrixXd motions(size, wanted);
  const Eigen::VectorXd scattered = scattered_vector(size * wanted);
  motions = Eigen::Map<const Eigen::MatrixXd>(scattered.data(), size, wanted);
  double value = 0.0;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> basis(factors.solve(motions));
    motions = basis.householderQ() * Eigen::MatrixXd::Identity(size, wanted);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> inside(motions.transpose() * (stiffness * motions));
    motions = motions * inside.eigenvectors();
    const double last = value;
    value = inside.eigenvalues()[free_motions];
    if (std::abs(value - last) <= accuracy * value) break;
  }
  // Within rounding of the motions that nothing resists: nothing is known about it.
  if (!(value > 10.0 * shift * greatest)) return std::nullopt;
  const Eigen::VectorXd mode = motions.col(free_motions);
  const double frequency = std::sqrt(value);  // rad/s
  return Vibration{2.0 * std::acos(-1.0) / frequency, mode.dot(matrices.damping() * mode) / (2.0 * frequency)};
}

}  // namespace springnet
