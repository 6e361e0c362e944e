// Small parts of contact by themselves, against closed forms: systems of constraints and their effective mobility, the
// smallest value on a path, what obstacles tell of their motion, forces between nodes that stick, surfaces that close.
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>

#include "constraints/bracing.hpp"
#include "constraints/constraint_system.hpp"
#include "constraints/contact.hpp"
#include "constraints/island.hpp"
#include "constraints/path_minimum.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("impulses of constraints are the transpose of their rates") {
  ConstraintSystem system;
  const Vector3 d = Vector3(1, 2, -2) / 3.0;
  system.set({{0, 1, d}, {1, ConstraintRow::no_node, Vector3::UnitZ(), 0}, {2, 1, Vector3::UnitX()}},
             [](std::uint32_t) -> Eigen::Matrix3d { return Eigen::Matrix3d::Identity(); });
  const std::vector<Vector3> v{{0.3, -1, 2}, {0.7, 0.2, -0.4}, {-1.5, 0, 0.9}};
  const Eigen::VectorXd rates = system.rates([&](std::uint32_t node) { return v[node]; });
  CHECK(rates[0] == doctest::Approx(d.dot(v[0] - v[1])));
  CHECK(rates[1] == doctest::Approx(v[1].z()));
  CHECK(rates[2] == doctest::Approx(v[2].x() - v[1].x()));
  const Vector3 ground(0, 0, 0.25);
  CHECK(system.rates([&](std::uint32_t node) { return v[node]; }, [&](const ConstraintRow&) { return ground; })[1] ==
        doctest::Approx(v[1].z() - 0.25));
  const Eigen::Vector3d x(2.0, -0.5, 1.25);
  double power = 0.0;
  system.for_each_impulse(x, [&](std::uint32_t node, const Vector3& impulse) { power += impulse.dot(v[node]); });
  CHECK(power == doctest::Approx(x.dot(rates)));
}

TEST_CASE("along a rod two masses move as one, across it each by itself") {
  ConstraintSystem system;
  const auto own = [](std::uint32_t node) -> Eigen::Matrix3d {
    return Eigen::Matrix3d::Identity() / (node == 0 ? 1.0 : 3.0);
  };
  system.set({{0, 1, Vector3::UnitX()}}, own);
  const Eigen::MatrixXd mobility = system.effective_mobility({1, 0}, own);
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(6, 6);
  expected.diagonal() << 0.25, 1.0 / 3.0, 1.0 / 3.0, 0.25, 1.0, 1.0;
  expected(0, 3) = expected(3, 0) = 0.25;
  CHECK((mobility - expected).cwiseAbs().maxCoeff() <= 1e-12);
}

TEST_CASE("the smallest value on a path is found, or one that is low enough") {
  const auto parabola = [](double s) { return (s - 0.3) * (s - 0.3) - 1.0; };
  const PathMinimum minimum = minimum_on_path(parabola, -2.0, 60);
  CHECK(std::abs(minimum.share - 0.3) <= 1e-7);  // the square root of the values' rounding
  CHECK(minimum.value == doctest::Approx(-1.0));
  int asked = 0;
  const PathMinimum enough = minimum_on_path(
      [&](double s) {
        ++asked;
        return parabola(s);
      },
      -0.5, 60);
  CHECK(enough.value < -0.5);
  CHECK(asked == 2);
}

TEST_CASE("an obstacle knows whether its turn moves its shape, its thickness, and the nearest it may come") {
  Turn turn;
  turn.rate = 3.0;
  Plane plane;
  plane.turn = turn;
  CHECK(Obstacle(plane).turns_in_place());
  plane.normal = Vector3(0, 0.6, 0.8);
  CHECK_FALSE(Obstacle(plane).turns_in_place());
  CHECK(std::isinf(Obstacle(plane).inscribed_radius()));

  Instrument round;
  round.first = round.second = {1, 0, 0};
  round.radius = 0.5;
  round.turn = turn;
  CHECK(Obstacle(round).turns_in_place());
  CHECK(Obstacle(round).inscribed_radius() == 0.5);
  round.turn->through = Vector3(0, 0, 0);
  CHECK_FALSE(Obstacle(round).turns_in_place());
  round.turn->through.reset();
  round.second = {1, 0, 2};
  CHECK(Obstacle(round).turns_in_place());
  round.second = {1, 1, 2};
  CHECK_FALSE(Obstacle(round).turns_in_place());

  Instrument bar;
  bar.box = BoxShape{{2.0, 0.2, 0.4}, Eigen::Matrix3d::Identity(), 0.0};
  bar.turn = turn;
  const Obstacle box(bar);
  CHECK_FALSE(box.turns_in_place());
  CHECK(box.inscribed_radius() == doctest::Approx(0.1));
  // What rests beside it is never nearer, at any angle.
  const Vector3 beside(1.3, 0.4, 0.1);
  const double bound = box.min_gap(box.at(just_after(0.0)), beside);
  for (int i = 0; i < 100; ++i) CHECK(box.gap(box.at(just_after(0.03 * i)), beside) >= bound);
  CHECK(bound > 0.0);

  Plane shaken;
  shaken.motion.emplace();
  shaken.motion->amplitude = {0.3, 0, 0.2};
  shaken.motion->frequency = 2.0;
  shaken.motion->from = 1.0;
  const Obstacle table(shaken);
  CHECK(table.angular_frequency(0.5) == 0.0);
  CHECK(table.angular_frequency(1.5) == doctest::Approx(4.0 * std::numbers::pi));
  CHECK(table.min_gap(table.at(just_after(0.0)), {0, 0, 1}) == doctest::Approx(0.6));
}

TEST_CASE("the forces of least norm between sticking nodes satisfy their cones of friction") {
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  CHECK(min_norm_nonnegative(one(-1.0), Eigen::MatrixXd::Constant(1, 1, 2.0)).value()[0] == doctest::Approx(0.5));
  CHECK(min_norm_nonnegative(one(1.0), Eigen::MatrixXd::Constant(1, 1, 2.0)).value()[0] == doctest::Approx(0.0));
  CHECK_FALSE(min_norm_nonnegative(one(-1.0), Eigen::MatrixXd::Zero(1, 1)));
  // A rod presses with x and pushes along with x / 2, where 1 N draws: x / 2 <= mu (x - 1).
  const Eigen::Vector3d base(-1.0, 0.0, 0.0), rod(1.0, 0.5, 0.0);
  CHECK(min_norm_in_cones(base, rod, {{1.0, 0.0}}).value()[0] == doctest::Approx(2.0).epsilon(1e-6));
  CHECK(min_norm_in_cones(base, rod, {{2.0, 0.0}}).value()[0] == doctest::Approx(4.0 / 3.0).epsilon(1e-6));
  CHECK_FALSE(min_norm_in_cones(base, rod, {{0.4, 0.0}}));
}

TEST_CASE("friction of a node on two surfaces is shared as their cones bear it") {
  const std::vector<Vector3> normals{Vector3::UnitZ(), Vector3::UnitX()};
  const Vector3 reaction(2.0, 0.7, 4.0);
  // The first bears 0.3 times 4 N, the second 0.1 times 2 N.
  std::vector<Vector3> shares = share_reaction(normals, {0.3, 0.1}, reaction);
  REQUIRE(shares.size() == 2);
  CHECK((shares[0] - Vector3(0, 0.6, 4)).norm() <= 1e-15);
  CHECK((shares[1] - Vector3(2, 0.1, 0)).norm() <= 1e-15);
  shares = share_reaction(normals, {0.0, 0.2}, reaction);
  CHECK((shares[0] - Vector3(0, 0, 4)).norm() <= 1e-15);
  CHECK((shares[1] - Vector3(2, 0.7, 0)).norm() <= 1e-15);
}

TEST_CASE("surfaces that oppose each other leave no place where their gaps are too small together") {
  const auto closed = [](const std::vector<Plane>& planes, const Vector3& at) {
    Network net;
    net.add_node(point({0, 0, 0}));
    for (const Plane& plane : planes) net.add_plane(plane);
    const std::vector<std::uint32_t> number{0};
    const std::vector<double> mass{1.0};
    const Contact contact(net, number, number, mass);
    return contact.closed_around(*contact.at(just_after(0.0)), at, 1e-9);
  };
  const auto facing = [](const Vector3& normal, double distance) {
    Plane plane;
    plane.normal = normal;
    plane.point = -distance * normal;
    return plane;
  };
  const Vector3 x = Vector3::UnitX();
  CHECK(closed({facing(x, 0.1), facing(-x, 0.1)}, {0.2, 0, 0}).empty());
  CHECK(closed({facing(x, 0.1), facing(-x, -0.11)}, {0.0, 0, 0}) == std::vector<std::int32_t>{0, 1});
  // Three around an axis: the circle between them shrinks to nothing.
  const auto three = [&](double radius) {
    std::vector<Plane> planes;
    for (const double angle : {0.0, 2.0 * std::numbers::pi / 3.0, 4.0 * std::numbers::pi / 3.0})
      planes.push_back(facing({std::cos(angle), std::sin(angle), 0.0}, radius));
    return planes;
  };
  CHECK(closed(three(0.01), {0.1, 0, 0}).empty());
  CHECK(closed(three(-0.01), {0.001, 0, 0}).size() == 3);
}
