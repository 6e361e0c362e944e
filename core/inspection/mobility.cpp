#include "inspection/mobility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

namespace springnet {

namespace {

using Matrix = Eigen::SparseMatrix<double>;

// A motion counts as free if its stiffness is below this share of that of a spring. Bending of a beam of 100 cells has
// about 1e-8, rounding 1e-16.
constexpr double no_stiffness = 1e-12;
// Limits of size, for a few seconds of work including the symbolic factorisation.
constexpr Eigen::Index max_columns = 30000;
constexpr double max_operations = 1e10;

// Sylvester: a symmetric matrix has as many negative eigenvalues as its factorisation has negative pivots.
class Inertia : public Eigen::SimplicialLDLT<Matrix> {
 public:
  // Nullity of a positive semidefinite matrix M; empty if its factorisation would take too long. No pivoting is needed:
  // if a pivot of such a matrix is zero, so are its row and column. more: rows r whose r^T r belongs to M but would
  // fill it in. M + r^T r is the Schur complement of the pivot -1 in [M r^T; r -1], which thus has one more negative
  // pivot for each row.
  std::optional<std::size_t> nullity(const Matrix& square, const Matrix& more) {
    if (square.rows() == 0) return 0;
    const Eigen::Index size = square.rows() + more.rows();
    if (size > max_columns) return std::nullopt;
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index column = 0; column < square.cols(); ++column)
      for (Matrix::InnerIterator entry(square, column); entry; ++entry)
        entries.emplace_back(static_cast<int>(entry.row()), static_cast<int>(column), entry.value());
    for (Eigen::Index column = 0; column < more.cols(); ++column)
      for (Matrix::InnerIterator entry(more, column); entry; ++entry) {
        const int row = static_cast<int>(square.rows() + entry.row());
        entries.emplace_back(row, static_cast<int>(column), entry.value());
        entries.emplace_back(static_cast<int>(column), row, entry.value());
      }
    for (Eigen::Index k = 0; k < size; ++k)
      entries.emplace_back(static_cast<int>(k), static_cast<int>(k), k < square.rows() ? -no_stiffness : -1.0);
    Matrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    analyzePattern(matrix);
    const double operations = m_nonZerosPerCol.head(matrix.rows()).cast<double>().squaredNorm();
    if (operations > max_operations) return std::nullopt;
    factorize(matrix);
    if (info() != Eigen::Success) return std::nullopt;
    return static_cast<std::size_t>((vectorD().array() < 0.0).count()) - static_cast<std::size_t>(more.rows());
  }
};

// One row for each connection or element, with its direction in the columns of its free nodes.
class Directions {
 public:
  explicit Directions(const StartingNetwork& start) : network_(start.network()), column_(network_.nodes().size(), -1) {
    for (NodeIndex k = 0; k < column_.size(); ++k) {
      if (!start.is_free(k)) continue;
      column_[k] = columns_;
      columns_ += 3;
    }
  }
  // The row of an element: derivatives by its nodes, of any magnitude.
  void add(const std::vector<NodeIndex>& nodes, const std::vector<Vector3>& by_node) {
    double greatest = 0.0;
    for (std::size_t i = 0; i < nodes.size(); ++i) greatest = std::max(greatest, by_node[i].norm());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (column_[nodes[i]] < 0 || !(greatest > 0.0)) continue;
      for (int c = 0; c < 3; ++c) entries_.emplace_back(rows_, column_[nodes[i]] + c, by_node[i][c] / greatest);
    }
    ++rows_;
  }
  void add(NodeIndex first, NodeIndex second) {
    const Vector3 difference = network_.nodes()[first].position - network_.nodes()[second].position;
    const double length = difference.norm();
    for (const auto& [node, sign] : {std::pair{first, 1.0}, std::pair{second, -1.0}}) {
      if (column_[node] < 0 || !(length > 0.0)) continue;
      for (int c = 0; c < 3; ++c) {
        const double value = sign * difference[c] / length;
        if (value != 0.0) entries_.emplace_back(rows_, column_[node] + c, value);
      }
    }
    ++rows_;
  }
  [[nodiscard]] Matrix matrix() const {
    Matrix result(rows_, columns_);
    result.setFromTriplets(entries_.begin(), entries_.end());
    return result;
  }

 private:
  const Network& network_;
  std::vector<int> column_;
  int rows_ = 0, columns_ = 0;
  std::vector<Eigen::Triplet<double>> entries_;
};

// Counts the rigid-body motions of a part: of the six, those that leave its fixed nodes at rest and move another node.
class RigidBody {
 public:
  void add(const Vector3& position) {
    sum_ += position;
    ++count_;
    lower_ = lower_.cwiseMin(position);
    upper_ = upper_.cwiseMax(position);
  }
  // For each node, once all are added.
  void add_motion(const Vector3& position, bool free) {
    const double extent = (upper_ - lower_).norm();
    const Vector3 arm = (position - sum_ / static_cast<double>(count_)) / (extent > 0.0 ? extent : 1.0);
    Eigen::Matrix<double, 3, 6> motion;
    motion << Eigen::Matrix3d::Identity(),
        (Eigen::Matrix3d() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0).finished();
    (free ? moving_ : resisting_) += motion.transpose() * motion;
  }
  [[nodiscard]] std::size_t motions() const {
    // Squares of offsets relative to the extent: deviations of about 1e-6 from a line or plane are ignored.
    constexpr double none = 1e-11;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> held(resisting_);
    const auto kept = (held.eigenvalues().array() <= none).count();
    const Eigen::MatrixXd allowed = held.eigenvectors().leftCols(kept);
    if (kept == 0) return 0;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> seen(allowed.transpose() * moving_ * allowed);
    return static_cast<std::size_t>((seen.eigenvalues().array() > none).count());
  }

 private:
  Vector3 sum_ = Vector3::Zero();
  Vector3 lower_ = Vector3::Constant(std::numeric_limits<double>::infinity());
  Vector3 upper_ = Vector3::Constant(-std::numeric_limits<double>::infinity());
  std::size_t count_ = 0;
  Eigen::Matrix<double, 6, 6> moving_ = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 6> resisting_ = Eigen::Matrix<double, 6, 6>::Zero();
};

std::size_t rigid_body_motions(const StartingNetwork& start, const std::vector<std::uint32_t>& part,
                               std::size_t parts) {
  const Network& network = start.network();
  std::vector<RigidBody> bodies(parts);
  for (std::size_t k = 0; k < part.size(); ++k) bodies[part[k]].add(network.nodes()[k].position);
  for (NodeIndex k = 0; k < part.size(); ++k) bodies[part[k]].add_motion(network.nodes()[k].position, start.is_free(k));
  std::size_t sum = 0;
  for (const RigidBody& body : bodies) sum += body.motions();
  return sum;
}

}  // namespace

void count_mechanisms(const StartingNetwork& start, const std::vector<std::uint32_t>& part, Inspection& result) {
  const Network& network = start.network();
  Mobility& found = result.mobility;
  Directions all(start), rigid(start), volumes(start);
  for (std::size_t s = 0; s < start.springs().size(); ++s) {
    const SpringAtStart& spring = start.springs()[s];
    if (!network.materials()[network.springs()[s].material].spring) continue;
    if (spring.stiffness != 0.0) all.add(network.springs()[s].first, network.springs()[s].second);
    // Smaller tensions are rounding.
    const double rounding = 1e-12 * std::abs(spring.stiffness) * spring.length;
    found.springs_under_tension += spring.tension > rounding ? 1 : 0;
    found.springs_under_compression += spring.tension < -rounding ? 1 : 0;
  }
  for (std::size_t e = 0; e < start.elements().size(); ++e) {
    const ElementAtStart& element = start.elements()[e];
    const Element& described = network.elements()[e];
    if (!network.materials()[described.material].spring) continue;
    Directions& directions = described.invariant == Invariant::enclosed_volume ? volumes : all;
    for (const std::vector<Vector3>& direction : element.directions) directions.add(element.nodes, direction);
  }
  for (const Rigid& connection : network.rigids()) {
    all.add(connection.first, connection.second);
    rigid.add(connection.first, connection.second);
  }
  found.rigid_body_motions = rigid_body_motions(start, part, result.parts.size());
  const Matrix directions = all.matrix();
  const std::optional<std::size_t> motions = Inertia().nullity(directions.transpose() * directions, volumes.matrix());
  const Matrix constraints = rigid.matrix();
  const std::optional<std::size_t> redundant =
      Inertia().nullity(constraints * constraints.transpose(), Matrix(0, constraints.rows()));
  found.known = motions.has_value() && redundant.has_value();
  if (!found.known) return;
  found.redundant_rigids = *redundant;
  found.mechanisms = *motions - std::min(*motions, found.rigid_body_motions);
}

}  // namespace springnet
