// Nodes on surfaces in systems without a matrix: whatever block answers of them, x = C K x + b is what is solved.

#include <doctest/doctest.h>

#include <random>

#include <Eigen/Dense>

#include "layers/linear/node_response.hpp"

using namespace springnet;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using layers::NodeResponses;

namespace {

constexpr double mass = 0.7;

Matrix3d random_matrix(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Matrix3d result;
  for (Eigen::Index i = 0; i < 9; ++i) result.data()[i] = unit(random);
  return result;
}

// One node, whose own block is all there is: what preconditions solves.
Vector3d solution(const NodeResponses& responses, const Matrix3d& k, const Vector3d& b) {
  Matrix3d block = mass * (Matrix3d::Identity() - k);
  responses.for_each_addition([&](std::uint32_t node, const Matrix3d& extra, const Matrix3d& slip) {
    CHECK(node == 0);
    CHECK(slip.isZero(0.0));
    block += mass * extra;
  });
  double force[4] = {mass * b[0], mass * b[1], mass * b[2], 0.0};
  responses.take_right_side({0, 1}, force);
  Vector3d x = Vector3d::Constant(-1.0);
  CHECK(responses.for_each_inverse(
      [&](std::size_t) { return block; },
      [&](std::size_t, const Matrix3d& inverse) { x = inverse * Eigen::Map<const Vector3d>(force); }));
  return x;
}

}  // namespace

TEST_CASE("a node answers by any block, of rank 0 to 3, with and without friction") {
  std::mt19937 random(11);
  for (int turn = 0; turn < 40; ++turn) {
    const Vector3d n = random_matrix(random).col(0).normalized();
    const Vector3d other = random_matrix(random).col(0).cross(n).normalized();
    const Matrix3d off = Matrix3d::Identity() - n * n.transpose();
    const Matrix3d sticks = Matrix3d::Zero(), slides = off, edge = off - other * other.transpose();
    const Matrix3d rough = Matrix3d::Identity() - (n - 0.4 * other) * n.transpose();
    const Matrix3d turns = rough - 0.6 * n.cross(other) * n.cross(other).transpose();
    const Matrix3d any = random_matrix(random);
    const struct {
      Matrix3d response;
      bool symmetric;
    } cases[] = {{sticks, true}, {slides, true}, {edge, true}, {rough, false}, {turns, false}, {any, false}};
    for (std::size_t i = 0; i < std::size(cases); ++i) {
      CAPTURE(i);
      const Matrix3d& c = cases[i].response;
      NodeResponses responses;
      responses.set({{0, c, Matrix3d::Zero()}});
      CHECK(responses.any());
      CHECK(responses.symmetric() == cases[i].symmetric);
      const Matrix3d stiffness = random_matrix(random), k = -stiffness * stiffness.transpose();
      const Vector3d b = c * random_matrix(random).col(0);
      const Vector3d expected = (Matrix3d::Identity() - c * k).fullPivLu().solve(b);
      const double singular = (Matrix3d::Identity() - c * k).fullPivLu().rcond();
      CHECK((solution(responses, k, b) - expected).norm() <= 1e-12 / singular * (b.norm() + 1.0));
      // Nothing leaves the space of what it can do, and what is not seen does not come back.
      double change[4] = {1.0, 2.0, 3.0, 7.0};
      responses.allow({0, 1}, change);
      const Vector3d kept(change[0], change[1], change[2]);
      CHECK((c * (c.completeOrthogonalDecomposition().solve(kept)) - kept).norm() <= 1e-12);
      CHECK(change[3] == 7.0);
      double residual[4] = {1.0, 2.0, 3.0, 7.0};
      responses.see({0, 1}, residual);
      CHECK((c * (Vector3d(1.0, 2.0, 3.0) - Vector3d(residual[0], residual[1], residual[2]))).norm() <= 1e-12);
      double elsewhere[8] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0};
      responses.see({1, 2}, elsewhere);
      for (int j = 0; j < 8; ++j) CHECK(elsewhere[j] == j + 1.0);
    }
  }
}

TEST_CASE("friction along the slip makes a system that is not symmetric") {
  NodeResponses responses;
  responses.set({{3, Matrix3d::Identity() - Vector3d::UnitZ() * Vector3d::UnitZ().transpose(), Matrix3d::Identity()}});
  CHECK_FALSE(responses.symmetric());
  responses.set({});
  CHECK(responses.symmetric());
  CHECK_FALSE(responses.any());
}
