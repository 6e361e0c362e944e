// Impulses of many pairs on few nodes, as of faces on faces.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <Eigen/QR>

#include "constraints/independent_rows.hpp"
#include "constraints/pair_rows.hpp"
#include "constraints/vectors.hpp"

using namespace springnet;

namespace {

// The same numbers with every standard library.
class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double operator()(double from, double to) {
    return from + (to - from) * (static_cast<double>(random_()) / 4294967296.0);
  }
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(random_() % count); }
  Vector3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)}; }

 private:
  std::mt19937 random_;
};

constexpr double step = 1e-3, thickness = 0.01;  // s, m
// Faces that lie on each other a little shifted touch in several points near each corner, which hardly differ.
constexpr double near_corners = 0.1;

// A layer of nodes that has come to overlap another one below, with many more pairs than nodes. What pairs say of gaps
// agrees to `noise`, m.
struct Layers {
  static constexpr std::uint32_t side = 9;
  std::vector<double> values = std::vector<double>(12 * side);
  std::vector<double> mobility;
  std::vector<Matrix3> blocks;
  std::vector<PairRow> rows;

  Layers(Dice& dice, int pairs, double friction, double noise, bool with_blocks) {
    const MovedNodes nodes = moved();
    for (std::uint32_t k = 0; k < 2 * side; ++k) {
      const double height = k < side ? thickness - 1e-5 : 0.0;
      put_vector(nodes.position, k, Vector3(0.1 * (k % 3), 0.1 * (k / 3 % 3), height));
      put_vector(nodes.velocity, k, Vector3(0.3, 0.1, k < side ? -1.0 : 0.0) + dice.vector(0.01));
      mobility.push_back(1.0 / std::exp(dice(-7.0, 0.0)));
      const Vector3 along = dice.vector(1.0).normalized();
      blocks.push_back(mobility.back() * (Matrix3::Identity() - dice(0.0, 0.9) * along * along.transpose()));
    }
    uses_blocks = with_blocks;
    for (int r = 0; r < pairs; ++r) {
      PairRow row;
      row.count = 4;
      const bool edges = dice.below(2) == 0;
      const std::uint32_t a = dice.below(side), b = side + dice.below(side - 2);
      row.nodes = edges ? std::array{a, (a + 1) % side, b, b + 1} : std::array{a, b, b + 1, b + 2};
      const double u = near_corners * dice(0.0, 1.0), v = near_corners * dice(0.0, 1.0);
      row.weights = edges ? std::array{u, 1.0 - u, -v, v - 1.0} : std::array{1.0, -u, -v, u + v - 1.0};
      row.normal = (Vector3::UnitZ() + dice.vector(1e-4)).normalized();
      row.friction = friction;
      row.lever = step;
      row.value = -thickness + dice(-noise, noise);
      REQUIRE(set_mobility(row, moved()));
      rows.push_back(row);
    }
  }
  MovedNodes moved() {
    constexpr std::size_t n = 2 * side;
    double* const p = values.data();
    MovedNodes result{{p, p + n, p + 2 * n}, {p + 3 * n, p + 4 * n, p + 5 * n}, &mobility};
    if (uses_blocks) result.blocks = &blocks;
    return result;
  }
  bool uses_blocks = false;
};

// What makes impulses the solution, whatever found them.
void check_solution(Layers& layers) {
  const MovedNodes nodes = layers.moved();
  constexpr double same = 1e-12, speed = same / step;  // m, m/s
  int pressing = 0;
  for (const PairRow& row : layers.rows) {
    const double gap = row.value + row.normal.dot(relative(row, nodes.position)), along = row.normal.dot(row.impulse);
    const Vector3 rate = relative(row, nodes.velocity);
    const Vector3 slip = rate - row.normal * row.normal.dot(rate), across = row.impulse - along * row.normal;
    CHECK(along >= 0.0);
    CHECK(gap >= -same);
    CHECK(across.norm() <= row.friction * along * (1.0 + 1e-9) + 1e-15 * along);
    if (!(along > 1e-12)) continue;
    ++pressing;
    CHECK(std::abs(gap) <= same);
    if (!(row.friction > 0.0) || slip.norm() <= 1e3 * speed) continue;
    CHECK(across.norm() >= row.friction * along * (1.0 - 1e-6));
    CHECK(across.dot(slip) <= -(1.0 - 1e-6) * across.norm() * slip.norm());
  }
  CHECK(pressing >= 3);
}

}  // namespace

TEST_CASE("impulses of redundant pairs: no overlap, no pull, Coulomb's cone, in few iterations") {
  Dice dice(7);
  int alone = 0, solves = 0;  // iterations without Newton's method
  for (const double friction : {0.0, 0.1, 0.5})
    for (const double noise : {0.0, 1e-8, 1e-6})
      for (const bool with_blocks : {false, true})
        for (int i = 0; i < 5; ++i) {
          CAPTURE(friction);
          CAPTURE(noise);
          CAPTURE(i);
          Layers layers(dice, 60, friction, noise, with_blocks);
          Layers again = layers;
          const PairAccuracy accuracy{1e-14, 1e-14, 2000, 2000, 0.0, 10};
          const PairSolution found = solve(layers.rows, layers.moved(), step, accuracy);
          CHECK(found.residual <= 1e-13);
          CHECK(found.iterations <= 20);
          check_solution(layers);
          PairAccuracy without = accuracy;
          without.before_newton = without.most;
          alone += solve(again.rows, again.moved(), step, without).iterations;
          ++solves;
        }
  CHECK(alone > 40 * solves);
}

TEST_CASE("rows that others imply are left out, and the rest allows what all did") {
  Dice dice(11);
  for (int i = 0; i < 20; ++i) {
    Layers layers(dice, 4 + 5 * i, 0.0, 0.0, false);
    layers.mobility[3] = 0.0;  // does not move
    std::vector<ConstraintRow> rows;
    for (const PairRow& pair : layers.rows) {
      ConstraintRow row{pair.nodes[0], pair.nodes[1], dice.vector(1.0).normalized(), -1, pair.nodes[2],
                        pair.nodes[3], pair.weights};
      row.is_pair = true;
      rows.push_back(row);
      if (dice.below(3) == 0) rows.push_back(row);
    }
    const auto matrix_of = [&](const std::vector<ConstraintRow>& of) {
      Eigen::MatrixXd g = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(of.size()), 6 * Layers::side);
      for (std::size_t r = 0; r < of.size(); ++r)
        of[r].for_each_end([&](std::size_t, std::uint32_t node, double weight) {
          g.block<1, 3>(static_cast<Eigen::Index>(r), 3 * node) +=
              std::sqrt(layers.mobility[node]) * weight * of[r].direction.transpose();
        });
      return g;
    };
    const std::vector<ConstraintRow> few = independent_rows(rows, layers.mobility);
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> all(matrix_of(rows).transpose());
    all.setThreshold(1e-6);
    CHECK(static_cast<Eigen::Index>(few.size()) <= all.rank() + 1);
    // Each of them is a sum of those that stay.
    const Eigen::MatrixXd kept = matrix_of(few).transpose(), asked = matrix_of(rows).transpose();
    const Eigen::MatrixXd left = asked - kept * kept.colPivHouseholderQr().solve(asked);
    for (Eigen::Index r = 0; r < asked.cols(); ++r) CHECK(left.col(r).norm() <= 1.1e-4 * asked.col(r).norm());
  }
}
