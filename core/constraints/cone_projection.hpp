// Projection onto cones of friction, and Newton's method for convex functions of it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "constraints/cone_forces.hpp"

namespace springnet {

// The projection onto the cones, and its derivative times a matrix. Zhou and Chen, J. Nonlinear Convex Anal. 14 (2013),
// 807.
class ConeProjection {
 public:
  explicit ConeProjection(const std::vector<ForceCone>& cones) : cones_(cones) {}

  [[nodiscard]] Eigen::VectorXd of(const Eigen::VectorXd& x) const {
    Eigen::VectorXd result = x;
    for (const ForceCone& cone : cones_) {
      if (!cone.has_friction) {
        result[cone.first] = std::max(0.0, x[cone.first]);
        continue;
      }
      const double mu = cone.coefficient, n = x[cone.first];
      const Eigen::Vector2d t = x.segment<2>(cone.first + 1);
      const double size = t.norm();
      if (is_within(cone, x)) continue;
      if (mu * size <= -n) {
        result.segment<3>(cone.first).setZero();
        continue;
      }
      const double pressing = (n + mu * size) / (1.0 + mu * mu);
      result[cone.first] = pressing;
      result.segment<2>(cone.first + 1) = mu * pressing / size * t;
    }
    return result;
  }

  // rows := D rows, at x.
  void differentiate(const Eigen::VectorXd& x, Eigen::MatrixXd& rows) const {
    for (const ForceCone& cone : cones_) {
      if (!cone.has_friction) {
        if (x[cone.first] < 0.0) rows.row(cone.first).setZero();
      } else if (!is_within(cone, x)) {
        auto block = rows.middleRows<3>(cone.first);
        block = (derivative(cone, x) * block).eval();
      }
    }
  }
  // D, at x.
  [[nodiscard]] Eigen::SparseMatrix<double> derivative(const Eigen::VectorXd& x) const {
    std::vector<Eigen::Triplet<double>> entries;
    std::vector<std::uint8_t> is_free(static_cast<std::size_t>(x.size()), 1);
    for (const ForceCone& cone : cones_) {
      const Eigen::Index count = cone.has_friction ? 3 : 1;
      Eigen::Matrix3d block = Eigen::Matrix3d::Identity();
      if (!cone.has_friction)
        block(0, 0) = x[cone.first] < 0.0 ? 0.0 : 1.0;
      else if (!is_within(cone, x))
        block = derivative(cone, x);
      for (Eigen::Index r = 0; r < count; ++r) {
        is_free[static_cast<std::size_t>(cone.first + r)] = 0;
        for (Eigen::Index c = 0; c < count; ++c) entries.emplace_back(cone.first + r, cone.first + c, block(r, c));
      }
    }
    for (Eigen::Index r = 0; r < x.size(); ++r)
      if (is_free[static_cast<std::size_t>(r)] != 0) entries.emplace_back(r, r, 1.0);
    Eigen::SparseMatrix<double> result(x.size(), x.size());
    result.setFromTriplets(entries.begin(), entries.end());
    return result;
  }

 private:
  static bool is_within(const ForceCone& cone, const Eigen::VectorXd& x) {
    return x[cone.first] >= 0.0 && x.segment<2>(cone.first + 1).norm() <= cone.coefficient * x[cone.first];
  }
  // Outside of the cone.
  static Eigen::Matrix3d derivative(const ForceCone& cone, const Eigen::VectorXd& x) {
    const double mu = cone.coefficient, n = x[cone.first];
    const Eigen::Vector2d t = x.segment<2>(cone.first + 1);
    const double size = t.norm();
    if (mu * size <= -n) return Eigen::Matrix3d::Zero();
    const double share = 1.0 / (1.0 + mu * mu), pressing = share * (n + mu * size);
    const Eigen::Vector2d u = t / size;
    Eigen::Matrix3d d;
    d(0, 0) = share;
    d.block<1, 2>(0, 1) = share * mu * u.transpose();
    d.block<2, 1>(1, 0) = share * mu * u;
    d.block<2, 2>(1, 1) =
        share * mu * mu * u * u.transpose() + mu * pressing / size * (Eigen::Matrix2d::Identity() - u * u.transpose());
    return d;
  }

  const std::vector<ForceCone>& cones_;
};

// Minimises a convex function whose value and derivative evaluate(y, gradient) gives, by Newton's method with a search
// along each step: newton(y, gradient, weight) is the product of the inverse of its generalised second derivative and
// the gradient. weight: of what keeps steps short, less after each that needed no search. done(y, gradient): it ends.
template <class Evaluate, class Newton, class Done>
void minimise(Eigen::VectorXd& y, const Evaluate& evaluate, const Newton& newton, const Done& done) {
  constexpr int max_newton = 60, max_halvings = 40;
  constexpr double least_weight = 1e-6;
  constexpr double sufficient = 1e-4;  // share of the expected decrease that a step of the search has to reach
  Eigen::VectorXd gradient, next_gradient;
  double value = evaluate(y, gradient), weight = 1.0;
  for (int k = 0; k < max_newton && !done(y, gradient); ++k) {
    const Eigen::VectorXd step = -newton(y, gradient, weight);
    const double slope = gradient.dot(step);
    if (!(slope < 0.0)) return;
    double length = 1.0;
    Eigen::VectorXd next;
    double next_value = 0.0;
    int halvings = 0;
    for (;; length *= 0.5) {
      next = y + length * step;
      next_value = evaluate(next, next_gradient);
      // Near the end differences of values are rounding: there the gradient decides.
      if (next_value <= value + sufficient * length * slope || next_gradient.norm() <= 0.5 * gradient.norm()) break;
      if (++halvings > max_halvings) return;
    }
    weight = length < 1.0 ? 1.0 : std::max(least_weight, 0.1 * weight);
    y = next;
    value = next_value;
    gradient.swap(next_gradient);
  }
}

}  // namespace springnet
