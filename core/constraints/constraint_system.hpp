// Linear systems with the matrix G W G^T of constraints on nodes, where a row of G is a direction at one node, or the
// opposite directions at the two ends of a rigid connection.
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
  // How the system is factorised: as a full matrix or a sparse one over rows, or, where rows are many more than the
  // directions in which their nodes can move, as a sparse matrix over those.
  enum class Form { dense, rows, nodes };
  // Mobility of a node, 1/kg: its velocity changes by that times an impulse. Zero for a node that cannot move.
  using Mobility = std::function<Eigen::Matrix3d(std::uint32_t)>;

  ConstraintSystem();
  ~ConstraintSystem();
  ConstraintSystem(ConstraintSystem&&) noexcept;
  ConstraintSystem& operator=(ConstraintSystem&&) noexcept;

  // Factorises G W G^T. Redundant rows, and rows between nodes that cannot move, are allowed: see solve().
  void set(std::vector<ConstraintRow> rows, const Mobility& mobility);
  [[nodiscard]] const std::vector<ConstraintRow>& rows() const noexcept { return rows_; }
  [[nodiscard]] Form form() const noexcept { return form_; }
  // The multipliers x of G W G^T x = b. Where rows are redundant the right side has to fit, as it does if it comes from
  // velocities or lengths; of the many answers it is the smallest.
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
  // G v, one rate a row, m/s, of velocities of(node). A row without a second node stands on something that moves with
  // ground(row).
  template <class Of, class Ground>
  [[nodiscard]] Eigen::VectorXd rates(const Of& of, const Ground& ground) const {
    Eigen::VectorXd result(static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const ConstraintRow& row = rows_[r];
      const Vector3 other = row.second != ConstraintRow::no_node ? Vector3(of(row.second)) : Vector3(ground(row));
      result[static_cast<Eigen::Index>(r)] = row.direction.dot(of(row.first) - other);
    }
    return result;
  }
  template <class Of>
  [[nodiscard]] Eigen::VectorXd rates(const Of& of) const {
    return rates(of, [](const ConstraintRow&) -> Vector3 { return Vector3::Zero(); });
  }
  // G^T x: the impulses (N s) of multipliers; calls `add(node, impulse)` for both ends of every row.
  template <class Add>
  void for_each_impulse(const Eigen::VectorXd& multipliers, Add&& add) const {
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const Vector3 impulse = multipliers[static_cast<Eigen::Index>(r)] * rows_[r].direction;
      add(rows_[r].first, impulse);
      if (rows_[r].second != ConstraintRow::no_node) add(rows_[r].second, Vector3(-impulse));
    }
  }
  // W G^T x: the change of a node's velocity (m/s) by multipliers (N s); calls `add(node, change)` for both ends of
  // every row.
  template <class Add>
  void for_each_change(const Eigen::VectorXd& multipliers, Add&& add) const {
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const double x = multipliers[static_cast<Eigen::Index>(r)];
      add(rows_[r].first, Vector3(mobilities_[2 * r] * rows_[r].direction * x));
      if (rows_[r].second != ConstraintRow::no_node)
        add(rows_[r].second, Vector3(mobilities_[2 * r + 1] * rows_[r].direction * -x));
    }
  }
  // Effective mobility of some nodes, 1/kg: W - W G^T (G W G^T)^-1 G W, three rows and columns each.
  [[nodiscard]] Eigen::MatrixXd effective_mobility(const std::vector<std::uint32_t>& nodes,
                                                   const Mobility& mobility) const;

 private:
  void set_rows();
  bool set_nodes();
  [[nodiscard]] Eigen::VectorXd product(const Eigen::VectorXd& x) const;  // G W G^T x
  [[nodiscard]] Eigen::VectorXd solve_shifted(const Eigen::VectorXd& b) const;
  [[nodiscard]] Eigen::VectorXd solve_by_gradients(const Eigen::VectorXd& b) const;

  std::vector<ConstraintRow> rows_;
  std::vector<Eigen::Matrix3d> mobilities_;  // [row][2]
  Form form_ = Form::dense;
  double shift_ = 0.0;
  struct Matrices;  // and their factors: Eigen's templates for them are compiled in one file only
  std::unique_ptr<Matrices> matrices_;
};

}  // namespace springnet
