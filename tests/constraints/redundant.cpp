// Contacts with more forces than their motion determines, and slips that begin beside others.
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "constraints/cone_forces.hpp"
#include "constraints/friction.hpp"
#include "constraints/island.hpp"
#include "constraints/least_squares.hpp"

using namespace springnet;

namespace {

constexpr double singular = 1e-9;

// The same numbers with every standard library.
class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double operator()(double from = -1.0, double to = 1.0) {
    return from + (to - from) * (static_cast<double>(random_()) / 4294967296.0);
  }
  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index columns) {
    return Eigen::MatrixXd::NullaryExpr(rows, columns, [this] { return (*this)(); });
  }

 private:
  std::mt19937 random_;
};

// The point of a cone that is nearest to x, by bisection of the multiplier of |t| <= mu n.
Eigen::Vector3d nearest_in_cone(const Eigen::Vector3d& x, double mu) {
  const double size = x.tail<2>().norm();
  if (size <= mu * x[0]) return x;
  double low = 0.0, high = 1.0;  // share of the tangential part that is left
  for (int i = 0; i < 200; ++i) {
    const double share = 0.5 * (low + high);
    // On the boundary at (share size / mu, share size): does the rest of x point outwards or back along it?
    const double along = (x[0] - share * size / mu) / mu + (size - share * size);
    (along > 0.0 ? low : high) = share;
  }
  Eigen::Vector3d result;
  result << low * size / mu, low * x.tail<2>();
  return result;
}

// Random equations with more unknowns than they determine, that some forces in the cones satisfy.
struct Redundant {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right, inside;  // these
  std::vector<ForceCone> cones;
};

Redundant random_redundant(Dice& dice, int contacts, int equations, bool fits) {
  Redundant result;
  Eigen::VectorXd& inside = result.inside = Eigen::VectorXd::Zero(3 * contacts + 2);
  for (int i = 0; i < contacts; ++i) {
    const double mu = dice(0.1, 1.1), n = std::max(0.0, dice(-0.4, 1.0)), angle = dice(0.0, 6.0);
    inside.segment<3>(3 * i) << n, mu * n * std::cos(angle), mu * n * std::sin(angle);
    result.cones.push_back({3 * i, true, mu});
  }
  inside.tail<2>() << dice(0.0, 1.0), dice(-1.0, 0.0);
  result.cones.push_back({3 * contacts, false, 0.0});  // the last may have either sign
  result.matrix = dice.matrix(equations, inside.size());
  result.right = result.matrix * inside;
  if (fits) return result;
  // The first equation wants a pull of all normal forces.
  result.matrix.row(0).setZero();
  for (const ForceCone& cone : result.cones) result.matrix(0, cone.first) = 1.0;
  result.right[0] = -1.0;
  return result;
}

Eigen::VectorXd into_cones(Eigen::VectorXd x, const std::vector<ForceCone>& cones) {
  for (const ForceCone& cone : cones) {
    if (cone.has_friction)
      x.segment<3>(cone.first) = nearest_in_cone(x.segment<3>(cone.first), cone.coefficient);
    else
      x[cone.first] = std::max(0.0, x[cone.first]);
  }
  return x;
}

}  // namespace

// Dykstra's alternating projections of zero onto the equations and the cones end at the least vector in both. They
// share nothing with Newton's method on the dual problem, and are slow: 1e-5 is what 20,000 of them reach.
TEST_CASE("forces of redundant contacts are the least that satisfy the equations and lie in their cones") {
  Dice dice(5);
  int outside = 0;  // of the least forces without regard to cones
  for (int trial = 0; trial < 12; ++trial) {
    CAPTURE(trial);
    const Redundant problem = random_redundant(dice, 2 + trial % 3, 3 + trial % 3, true);
    const Solution least = solve_least_squares(problem.matrix, problem.right, singular);
    REQUIRE(least.kernel.cols() + least.row_space.cols() == problem.matrix.cols());
    CHECK((problem.matrix * least.kernel).norm() <= 1e-12 * problem.matrix.norm());
    const Eigen::VectorXd x = least_in_cones(least.x, least.row_space, least.kernel, problem.cones);
    CHECK((problem.matrix * x - problem.right).norm() <= 1e-11 * problem.right.norm());
    CHECK(margin_in_cones(x, problem.cones) >= -1e-11 * x.norm());
    Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size()), first = y, second = y;
    for (int k = 0; k < 20'000; ++k) {
      const Eigen::VectorXd before = y + first;
      const Eigen::VectorXd on = before + least.row_space * (least.row_space.transpose() * (least.x - before));
      first = before - on;
      const Eigen::VectorXd then = on + second;
      y = into_cones(then, problem.cones);
      second = then - y;
    }
    CHECK((x - y).norm() <= 1e-5 * y.norm());
    const Eigen::VectorXd sparse = least_with_resultants(problem.matrix.sparseView(), problem.inside, problem.cones);
    CHECK((sparse - x).norm() <= 1e-9 * x.norm());
    outside += margin_in_cones(least.x, problem.cones) < 0.0 ? 1 : 0;
  }
  CHECK(outside >= 6);
}

TEST_CASE("where no forces lie in all cones, those that are found lie nearest to them") {
  Dice dice(6);
  for (int trial = 0; trial < 8; ++trial) {
    CAPTURE(trial);
    const Redundant problem = random_redundant(dice, 2 + trial % 3, 3 + trial % 2, false);
    const Solution least = solve_least_squares(problem.matrix, problem.right, singular);
    const Eigen::VectorXd x = least_in_cones(least.x, least.row_space, least.kernel, problem.cones);
    CHECK((problem.matrix * x - problem.right).norm() <= 1e-9 * problem.right.norm());
    Eigen::VectorXd on = least.x;
    for (int k = 0; k < 20'000; ++k) {
      const Eigen::VectorXd in = into_cones(on, problem.cones);
      on = in + least.row_space * (least.row_space.transpose() * (least.x - in));
    }
    const double distance = (on - into_cones(on, problem.cones)).norm();
    REQUIRE(distance > 1e-3);
    CHECK((x - into_cones(x, problem.cones)).norm() == doctest::Approx(distance).epsilon(1e-3));
    CHECK(margin_in_cones(x, problem.cones) < 0.0);
  }
}

// Two contacts share a pull, and beside them three share a weight that least squares put outside of their cones: these
// are inside as if they were alone.
TEST_CASE("forces that fit no cones leave those beside them in theirs") {
  Dice dice(8);
  const Redundant good = random_redundant(dice, 3, 4, true);
  const Solution alone = solve_least_squares(good.matrix, good.right, singular);
  REQUIRE(margin_in_cones(alone.x, good.cones) < -1e-3);
  const Eigen::VectorXd wanted = least_in_cones(alone.x, alone.row_space, alone.kernel, good.cones);
  const Eigen::Index count = good.matrix.cols();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(5, count + 2);
  matrix.topLeftCorner(4, count) = good.matrix;
  matrix.bottomRightCorner(1, 2).setOnes();
  Eigen::VectorXd right(5);
  right << good.right, -1.0;
  std::vector<ForceCone> cones = good.cones;
  for (const Eigen::Index i : {count, count + 1}) cones.push_back({i, false, 0.0});
  const Solution both = solve_least_squares(matrix, right, singular);
  const Eigen::VectorXd x = least_in_cones(both.x, both.row_space, both.kernel, cones);
  CHECK((x.head(count) - wanted).norm() <= 1e-9 * wanted.norm());
  CHECK(margin_in_cones(x, good.cones) >= -1e-11);
  for (const Eigen::Index i : {count, count + 1}) CHECK(x[i] == doctest::Approx(-0.5).epsilon(1e-5));
}

// A slip that has no speed yet is parallel to its acceleration, whatever the other pairs, which go on sticking, do:
// with an island of nodes that move each other strongly, steps from one direction to the next do not find it.
TEST_CASE("a pair begins to slip along its acceleration while others stick") {
  Dice dice(11);
  const double mu = 0.3;
  int slipped = 0;
  for (int trial = 0; trial < 200; ++trial) {
    CAPTURE(trial);
    const int count = 2 + trial % 3;
    const Eigen::MatrixXd roots = dice.matrix(3 * count, 3 * count);
    const Eigen::MatrixXd mobility = roots * roots.transpose() + 0.01 * Eigen::MatrixXd::Identity(3 * count, 3 * count);
    // What holds them all: in the cones, but for the first, which is a little beyond its own.
    Eigen::VectorXd forces(3 * count);
    for (int i = 0; i < count; ++i) {
      const double angle = dice(0.0, 6.0), share = i == 0 ? 1.001 : 0.3;
      forces.segment<3>(3 * i) << share * mu * std::cos(angle), share * mu * std::sin(angle), 1.0;
    }
    const Eigen::VectorXd free = -mobility * forces;
    std::vector<ContactNode> nodes;
    for (int i = 0; i < count; ++i) {
      ContactNode node;
      node.pair = i;
      node.sticks = true;
      node.acceleration = free.segment<3>(3 * i);
      ContactSide side;
      side.friction = {Friction::Kind::coulomb, mu};
      node.sides.push_back(side);
      nodes.push_back(node);
    }
    Island island(std::move(nodes), mobility);
    island.solve();
    for (int i = 0; i < count; ++i) REQUIRE((island.nodes()[i].force - forces.segment<3>(3 * i)).norm() <= 1e-6);
    island.begin_slip(0);
    island.solve();
    const ContactNode& first = island.nodes()[0];
    const Vector3 a = island.acceleration(0);
    for (int i = 1; i < count; ++i) CHECK(island.acceleration(i).norm() <= 1e-8);
    // Where friction turns back what it is to hold, no slip of one alone fits.
    if (!(a.dot(first.slip) > 0.0) || !(first.normal_force[0] > 0.0)) continue;
    ++slipped;
    CHECK(std::abs(a[2]) <= 1e-8);
    CHECK(a.normalized().dot(first.slip) == doctest::Approx(1.0).epsilon(1e-9));
    CHECK((first.force.head<2>() + mu * first.force[2] * first.slip.head<2>()).norm() <= 1e-10);
  }
  CHECK(slipped >= 150);
}
