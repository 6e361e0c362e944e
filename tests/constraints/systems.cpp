// Systems of redundant rigid connections in each of their forms, against dense least squares.

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include <fmt/format.h>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "constraints/constraint_system.hpp"

using namespace springnet;

namespace {

using Form = ConstraintSystem::Form;

// Nodes with rods between them.
struct Piece {
  std::string name;
  std::vector<Vector3> positions;
  std::vector<double> masses;  // kg; 0: fixed
  std::vector<ConstraintRow> rows;

  void join(std::size_t a, std::size_t b) {
    const Vector3 d = positions[a] - positions[b];
    if (!(d.norm() > 0.0)) return;  // coincident nodes are no connection's ends
    rows.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), d.normalized()});
  }
  [[nodiscard]] Eigen::Matrix3d mobility(std::uint32_t node) const {
    return masses[node] > 0.0 ? Eigen::Matrix3d(Eigen::Matrix3d::Identity() / masses[node]) : Eigen::Matrix3d::Zero();
  }
};

enum class Shape { solid, flat, line, coincident };

// joined: to how many nodes before it each is; 3 is just enough for a solid one.
Piece random_piece(std::mt19937_64& random, std::size_t count, std::size_t joined, Shape shape, double decades,
                   std::size_t fixed) {
  constexpr const char* names[] = {"solid", "flat", "on a line", "with coincident nodes"};
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Piece piece;
  piece.name = fmt::format("{} nodes {}, each joined to {}, masses over {} decades, {} fixed", count,
                           names[static_cast<int>(shape)], joined, decades, fixed);
  for (std::size_t k = 0; k < count; ++k) {
    Vector3 p(unit(random), unit(random), unit(random));
    if (shape == Shape::flat) p.z() = 0.0;
    if (shape == Shape::line) p = unit(random) * Vector3(1, 2, -2) / 3.0;
    if (shape == Shape::coincident && k % 4 == 3) p = piece.positions[k - 1];
    piece.positions.push_back(p);
    piece.masses.push_back(k < fixed ? 0.0 : std::pow(10.0, 0.5 * decades * unit(random)));
    for (std::size_t j = 1; j <= std::min(joined, k); ++j) piece.join(k - j, k);
  }
  return piece;
}

// A = G W^(1/2), dense.
Eigen::MatrixXd scaled_rows(const Piece& piece) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(piece.rows.size()),
                                            static_cast<Eigen::Index>(3 * piece.positions.size()));
  for (std::size_t r = 0; r < piece.rows.size(); ++r) {
    const ConstraintRow& row = piece.rows[r];
    for (const auto& [node, sign] : {std::pair{row.first, 1.0}, std::pair{row.second, -1.0}}) {
      if (piece.masses[node] > 0.0)
        a.block<1, 3>(static_cast<Eigen::Index>(r), 3 * static_cast<Eigen::Index>(node)) =
            sign / std::sqrt(piece.masses[node]) * row.direction.transpose();
    }
  }
  return a;
}

// The same with as many rods apart from it as make rows fewer than the directions of nodes.
Piece among_rods(const Piece& piece) {
  Piece result = piece;
  while (3 * result.positions.size() <= result.rows.size() + 3 * piece.positions.size()) {
    const Vector3 at(0, 0, 5.0 + static_cast<double>(result.positions.size()));
    result.positions.insert(result.positions.end(), {at, at + Vector3::UnitX()});
    result.masses.insert(result.masses.end(), 2, 1.0);
    result.join(result.positions.size() - 2, result.positions.size() - 1);
  }
  return result;
}

struct Difference {
  Form form;
  double change;      // of velocities, in the norm of the kinetic energy, of what was to change
  double multiplier;  // of the greatest
};

// b: the right side. What is left of the answer is compared with W^(-1/2) times the change of velocities.
Difference against(const Piece& piece, const Eigen::VectorXd& b, const Eigen::VectorXd& scaled_change,
                   const Eigen::VectorXd& multipliers) {
  ConstraintSystem system;
  system.set(piece.rows, [&](std::uint32_t node) { return piece.mobility(node); });
  Eigen::VectorXd right_side = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(piece.rows.size()));
  right_side.head(b.size()) = b;
  const Eigen::VectorXd x = system.solve(right_side);
  Eigen::VectorXd change = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * piece.positions.size()));
  system.for_each_change(x, [&](std::uint32_t node, const Vector3& more) {
    if (piece.masses[node] > 0.0)
      change.segment<3>(3 * static_cast<Eigen::Index>(node)) += std::sqrt(piece.masses[node]) * more;
    else
      CHECK(more.norm() == 0.0);
  });
  return {system.form(), (change.head(scaled_change.size()) - scaled_change).norm() / scaled_change.norm(),
          (x.head(b.size()) - multipliers).cwiseAbs().maxCoeff() / multipliers.cwiseAbs().maxCoeff()};
}

}  // namespace

TEST_CASE("redundant rigid connections are solved alike over rows and over nodes, as by dense least squares") {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  int seen[3] = {};
  for (const double decades : {0.0, 6.0}) {
    for (const Shape shape : {Shape::solid, Shape::flat, Shape::line, Shape::coincident}) {
      for (const std::size_t count : {5u, 8u, 9u, 12u, 13u, 20u}) {
        for (const std::size_t joined : {std::size_t{3}, std::size_t{5}, count}) {
          for (const std::size_t fixed : {0u, 1u, 4u}) {
            const Piece piece = random_piece(random, count, joined, shape, decades, fixed);
            if (piece.rows.empty()) continue;
            INFO(piece.name);
            const Eigen::MatrixXd a = scaled_rows(piece);
            Eigen::VectorXd w(a.cols());
            for (double& value : w) value = normal(random);
            // x with the least norm and A A^T x = A w, by way of A^T x = the part of w in the rows' span: the matrix is
            // not squared, so that its rank is plain in spite of the masses.
            Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> dense(a.transpose());
            dense.setThreshold(1e-12);
            const Eigen::VectorXd x = dense.solve(w);
            const Eigen::VectorXd change = a.transpose() * x;
            const Difference own = against(piece, a * w, change, x);
            const Difference by_rows = against(among_rods(piece), a * w, change, x);
            ++seen[static_cast<int>(own.form)];
            ++seen[static_cast<int>(by_rows.form)];
            // An answer whose rest is rounding is off by eps times the condition of A A^T. Of multipliers, what does
            // not move anything is rounding, some eps, over the shift, 1e-9.
            const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(a).singularValues();
            const double least = values[dense.rank() - 1], condition = values[0] * values[0] / (least * least);
            const double rounding = 10.0 * std::numeric_limits<double>::epsilon();
            for (const Difference& difference : {own, by_rows}) {
              INFO("form " << static_cast<int>(difference.form) << ", condition " << condition);
              CHECK(difference.change <= rounding * (condition + 10.0));
              CHECK(difference.multiplier <= rounding * (condition + 1e10));
            }
          }
        }
      }
    }
  }
  for (const int times : seen) CHECK(times > 10);  // every form
}
