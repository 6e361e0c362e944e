// Linear systems with the constraint matrix G W G^T. A row of G is a direction at one node, opposite directions at the
// two ends of a rigid connection, or the weighted ones of a pair's nodes; W are the nodes' mobilities.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "layers/linear/constraint_row.hpp"

namespace springnet {

class ConstraintSystem {
 public:
  // How the system is factorised: a dense or sparse matrix over rows; or, if rows outnumber the nodes' degrees of
  // freedom, a sparse matrix over these.
  enum class Form { dense, rows, nodes };
  // Mobility W of a node, 1/kg: dv = W J for an impulse J. Zero for a node that cannot move.
  using Mobility = std::function<Eigen::Matrix3d(std::uint32_t)>;

  ConstraintSystem();
  ~ConstraintSystem();
  ConstraintSystem(ConstraintSystem&&) noexcept;
  ConstraintSystem& operator=(ConstraintSystem&&) noexcept;

  // Factorises G W G^T. Redundant rows, and rows between nodes that cannot move, are allowed: see solve().
  void set(std::vector<ConstraintRow> rows, const Mobility& mobility);
  [[nodiscard]] const std::vector<ConstraintRow>& rows() const noexcept { return rows_; }
  [[nodiscard]] Form form() const noexcept { return form_; }
  // The multipliers x of G W G^T x = b. With redundant rows b must be in the range of the matrix, as it is if it comes
  // from velocities or lengths; x is then the solution of least norm.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  // G v, one rate a row, m/s, from velocities of(node). A row without a second node is relative to ground(row), m/s.
  template <class Of, class Ground>
  [[nodiscard]] Eigen::VectorXd rates(const Of& of, const Ground& ground) const {
    Eigen::VectorXd result(static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const ConstraintRow& row = rows_[r];
      Vector3 sum = Vector3::Zero();
      row.for_each_end([&](std::size_t, std::uint32_t node, double weight) { sum += weight * Vector3(of(node)); });
      if (row.second == ConstraintRow::no_node) sum -= Vector3(ground(row));
      result[static_cast<Eigen::Index>(r)] = row.direction.dot(sum);
    }
    return result;
  }
  template <class Of>
  [[nodiscard]] Eigen::VectorXd rates(const Of& of) const {
    return rates(of, [](const ConstraintRow&) -> Vector3 { return Vector3::Zero(); });
  }
  // G^T x: the impulses (N s) of multipliers; calls `add(node, impulse)` for all ends of every row.
  template <class Add>
  void for_each_impulse(const Eigen::VectorXd& multipliers, Add&& add) const {
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const Vector3 impulse = multipliers[static_cast<Eigen::Index>(r)] * rows_[r].direction;
      rows_[r].for_each_end(
          [&](std::size_t, std::uint32_t node, double weight) { add(node, Vector3(weight * impulse)); });
    }
  }
  // W G^T x: the velocity changes (m/s) of multipliers (N s); calls `add(node, change)` for all ends of every row.
  template <class Add>
  void for_each_change(const Eigen::VectorXd& multipliers, Add&& add) const {
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const double x = multipliers[static_cast<Eigen::Index>(r)];
      rows_[r].for_each_end([&](std::size_t i, std::uint32_t node, double weight) {
        add(node, Vector3(mobility(r, i) * rows_[r].direction * (x * weight)));
      });
    }
  }
  // Effective mobility of some nodes, 1/kg: W - W G^T (G W G^T)^-1 G W, three rows and columns a node.
  [[nodiscard]] Eigen::MatrixXd effective_mobility(const std::vector<std::uint32_t>& nodes,
                                                   const Mobility& mobility) const;

 private:
  void set_rows();
  bool set_nodes();
  [[nodiscard]] Eigen::VectorXd product(const Eigen::VectorXd& x) const;  // G W G^T x
  [[nodiscard]] Eigen::VectorXd solve_shifted(const Eigen::VectorXd& b) const;
  [[nodiscard]] Eigen::VectorXd solve_by_conjugate_gradients(const Eigen::VectorXd& b) const;

  [[nodiscard]] const Eigen::Matrix3d& mobility(std::size_t row, std::size_t end) const {
    return mobilities_[ends_ * row + end];
  }

  std::vector<ConstraintRow> rows_;
  std::size_t ends_ = 2;                     // of a row, at most
  std::vector<Eigen::Matrix3d> mobilities_;  // [row][ends_]
  Form form_ = Form::dense;
  double shift_ = 0.0;
  struct Matrices;  // and their factors: Eigen's templates for them are compiled in one file only
  std::unique_ptr<Matrices> matrices_;
};

}  // namespace springnet
