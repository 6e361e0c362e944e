#include "constraints/bracing.hpp"

#include <algorithm>

#include "constraints/friction.hpp"
#include "constraints/least_squares.hpp"

namespace springnet {
namespace {

constexpr int max_cuts = 100;  // of cutting planes

// Minimises |columns u - goal| over u >= 0. Lawson and Hanson, Solving Least Squares Problems (1974), chapter 23.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& columns, const Eigen::VectorXd& goal) {
  const Eigen::Index count = columns.cols();
  Eigen::VectorXd u = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::Index> passive;
  for (Eigen::Index iteration = 0; iteration < 3 * count; ++iteration) {
    const Eigen::VectorXd gain = columns.transpose() * (goal - columns * u);
    Eigen::Index best = -1;
    for (Eigen::Index j = 0; j < count; ++j)
      if (std::find(passive.begin(), passive.end(), j) == passive.end() && gain[j] > 1e-13 &&
          (best < 0 || gain[j] > gain[best]))
        best = j;
    if (best < 0) break;
    passive.push_back(best);
    for (bool inside = false; !inside;) {
      const Eigen::VectorXd z = least_squares(columns(Eigen::all, passive), goal);
      double share = 1.0;
      for (std::size_t i = 0; i < passive.size(); ++i)
        if (const double at = z[static_cast<Eigen::Index>(i)]; at <= 0.0)
          share = std::min(share, u[passive[i]] / (u[passive[i]] - at));
      inside = share >= 1.0;
      std::vector<Eigen::Index> kept;
      for (std::size_t i = 0; i < passive.size(); ++i) {
        const double at = z[static_cast<Eigen::Index>(i)];
        u[passive[i]] += share * (at - u[passive[i]]);
        if (!inside && at <= 0.0 && u[passive[i]] <= 1e-15)
          u[passive[i]] = 0.0;
        else
          kept.push_back(passive[i]);
      }
      inside = inside || kept.size() == passive.size();
      passive = kept;
    }
  }
  return u;
}

}  // namespace

// Least distance programming: ibid., chapter 23.4.
std::optional<Eigen::VectorXd> min_norm_nonnegative(const Eigen::VectorXd& base, const Eigen::MatrixXd& matrix) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(matrix.cols());
  const double size = base.size() > 0 ? base.lpNorm<Eigen::Infinity>() : 0.0, negligible = 1e-12 * size;
  if (base.size() == 0 || base.minCoeff() >= -negligible) return x;
  const double greatest = matrix.size() > 0 ? matrix.rowwise().norm().maxCoeff() : 0.0;
  if (!(greatest > 0.0)) return std::nullopt;
  Eigen::MatrixXd columns(matrix.cols() + 1, base.size());
  for (Eigen::Index r = 0; r < base.size(); ++r) {
    columns.col(r).head(matrix.cols()) = matrix.row(r).transpose() / greatest;
    columns(matrix.cols(), r) = -base[r] / size;
  }
  const Eigen::VectorXd goal = Eigen::VectorXd::Unit(columns.rows(), matrix.cols());
  const Eigen::VectorXd residual = columns * nonnegative_least_squares(columns, goal) - goal;
  const double last = residual[matrix.cols()];
  if (!(last < -1e-12)) return std::nullopt;
  x = -residual.head(matrix.cols()) / last * (size / greatest);
  if ((base + matrix * x).minCoeff() < -1e-9 * size) return std::nullopt;
  return x;
}

// Cutting planes: starts from the half-spaces normal force >= min_normal_force; whenever a force is outside of its
// cone, adds the half-space whose boundary touches the cone nearest to that force.
std::optional<Eigen::VectorXd> min_norm_in_cones(const Eigen::VectorXd& base, const Eigen::MatrixXd& matrix,
                                                 const std::vector<Cone>& cones) {
  const auto normals = static_cast<Eigen::Index>(cones.size());
  // Margin, N, inside of the cone: rounding must not make a force on its boundary slip.
  const double inside = 1e-9 * base.lpNorm<Eigen::Infinity>();
  Eigen::VectorXd from(normals);
  Eigen::MatrixXd rows(normals, matrix.cols());
  for (Eigen::Index i = 0; i < normals; ++i) {
    from[i] = base[3 * i] - cones[static_cast<std::size_t>(i)].min_normal_force;
    rows.row(i) = matrix.row(3 * i);
  }
  for (int round = 0; round < max_cuts; ++round) {
    const std::optional<Eigen::VectorXd> x = min_norm_nonnegative(from, rows);
    if (!x) return std::nullopt;
    const Eigen::VectorXd forces = base + matrix * *x;
    bool fits = true;
    for (Eigen::Index i = 0; i < normals; ++i) {
      const double mu = cones[static_cast<std::size_t>(i)].coefficient;
      const Eigen::Vector2d along = forces.segment<2>(3 * i + 1);
      const double size = along.norm();
      if (size == 0.0 || cone_margin(mu, forces[3 * i], size) >= 0.5 * inside) continue;
      fits = false;
      const Eigen::Vector2d against = along / size;
      from.conservativeResize(from.size() + 1);
      rows.conservativeResize(rows.rows() + 1, Eigen::NoChange);
      from[from.size() - 1] = mu * base[3 * i] - against.dot(base.segment<2>(3 * i + 1)) - inside;
      rows.row(rows.rows() - 1) = mu * matrix.row(3 * i) - against.transpose() * matrix.middleRows<2>(3 * i + 1);
    }
    if (fits) return x;
  }
  return std::nullopt;
}

}  // namespace springnet
