#include "constraints/cone_forces.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "constraints/cone_projection.hpp"
#include "constraints/friction.hpp"

namespace springnet {
namespace {

constexpr double accuracy = 1e-14;     // of resultants, in units of the least forces
constexpr double greatest = 1e6;       // forces that count as none, in the same units
constexpr double towards_last = 1e-6;  // weight of the change in a round beside that of distances from cones
constexpr int most_rounds = 3;         // each leaves as much of what the last one was off

// The dual problem: with the resultants d = C base of the rows C, the least x in the cones with C x = d is the
// projection of C^T y onto them, where y maximises d.y - |projection|^2/2. Empty: no such x is smaller than `greatest`.
std::optional<Eigen::VectorXd> least_within(const Eigen::VectorXd& base, const Eigen::MatrixXd& row_space,
                                            const ConeProjection& project) {
  const Eigen::VectorXd d = row_space.transpose() * base;
  const double size = d.norm();
  if (size == 0.0) return Eigen::VectorXd(Eigen::VectorXd::Zero(base.size()));
  Eigen::VectorXd y = d, x;
  bool is_found = false;
  const auto evaluate = [&](const Eigen::VectorXd& at, Eigen::VectorXd& gradient) {
    x = project.of(row_space * at);
    gradient = row_space.transpose() * x - d;
    return 0.5 * x.squaredNorm() - d.dot(at);
  };
  const auto newton = [&](const Eigen::VectorXd& at, const Eigen::VectorXd& gradient,
                          double weight) -> Eigen::VectorXd {
    Eigen::MatrixXd moved = row_space;
    project.differentiate(row_space * at, moved);
    Eigen::MatrixXd matrix = row_space.transpose() * moved;
    matrix.diagonal().array() += 1e-12 + 1e-4 * weight * std::min(1.0, gradient.norm() / size);
    return matrix.ldlt().solve(gradient);
  };
  minimise(y, evaluate, newton, [&](const Eigen::VectorXd& at, const Eigen::VectorXd& gradient) {
    is_found = gradient.norm() <= accuracy * size;
    if (is_found) return true;
    // For each x in the cones with C x = d it holds that d.u = x.(C^T u) <= |x| |projection of C^T u|, whatever u. The
    // missing part of d shows soonest that there is none.
    const Eigen::VectorXd lacks = -gradient;
    const auto shows_none = [&](const Eigen::VectorXd& u, double projected) {
      return d.dot(u) > 1e-12 * size * u.norm() && d.dot(u) > greatest * size * projected;
    };
    return shows_none(at, x.norm()) || shows_none(lacks, project.of(row_space * lacks).norm());
  });
  Eigen::VectorXd gradient;
  evaluate(y, gradient);
  if (!is_found && !(gradient.norm() <= 1e-10 * size)) return std::nullopt;
  return Eigen::VectorXd(x - row_space * gradient);
}

// Proximal point iteration: Newton's method needs what is not determined to be kept by something.
Eigen::VectorXd nearest(const Eigen::VectorXd& base, const Eigen::MatrixXd& kernel, const ConeProjection& project,
                        int rounds) {
  const double size = base.norm();
  Eigen::VectorXd z = Eigen::VectorXd::Zero(kernel.cols()), centre = z;
  const auto at = [&](const Eigen::VectorXd& by) -> Eigen::VectorXd { return base + kernel * by; };
  const auto evaluate = [&](const Eigen::VectorXd& by, Eigen::VectorXd& gradient) {
    const Eigen::VectorXd x = at(by), outside = x - project.of(x);
    gradient = kernel.transpose() * outside + towards_last * (by - centre);
    return 0.5 * outside.squaredNorm() + 0.5 * towards_last * (by - centre).squaredNorm();
  };
  const auto newton = [&](const Eigen::VectorXd& by, const Eigen::VectorXd& gradient, double) -> Eigen::VectorXd {
    Eigen::MatrixXd moved = kernel;
    project.differentiate(at(by), moved);
    Eigen::MatrixXd matrix = kernel.transpose() * (kernel - moved);
    matrix.diagonal().array() += towards_last;
    return matrix.ldlt().solve(gradient);
  };
  for (int round = 0; round < rounds; ++round, centre = z)
    minimise(z, evaluate, newton, [&](const Eigen::VectorXd&, const Eigen::VectorXd& gradient) {
      return gradient.norm() <= accuracy * size;
    });
  return at(z);
}

}  // namespace

double margin_in_cones(const Eigen::VectorXd& x, const std::vector<ForceCone>& cones) {
  double least = std::numeric_limits<double>::infinity();
  for (const ForceCone& cone : cones) {
    const double n = x[cone.first];
    least = std::min(least, n);
    if (cone.has_friction)
      least = std::min(least, cone_margin(cone.coefficient, n, x.segment<2>(cone.first + 1).norm()));
  }
  return least;
}

Eigen::VectorXd least_in_cones(const Eigen::VectorXd& base, const Eigen::MatrixXd& row_space,
                               const Eigen::MatrixXd& kernel, const std::vector<ForceCone>& cones) {
  if (base.isZero(0.0) || kernel.cols() == 0) return base;
  const ConeProjection project(cones);
  if (const std::optional<Eigen::VectorXd> within = least_within(base, row_space, project)) return *within;
  // What lies outside stays; the rest is as small as it can be. Where that is not found, the weight of the first round
  // makes the forces unique.
  const Eigen::VectorXd x = nearest(base, kernel, project, most_rounds), outside = x - project.of(x);
  const Eigen::VectorXd rest = base - row_space * (row_space.transpose() * outside);
  if (const std::optional<Eigen::VectorXd> within = least_within(rest, row_space, project)) return *within + outside;
  return nearest(base, kernel, project, 1);
}

}  // namespace springnet
