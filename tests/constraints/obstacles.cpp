// Obstacles by themselves: the distance from a box by its supporting planes, derivatives by differences, poses that
// turn, first touches.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "constraints/obstacle.hpp"
#include "dice.hpp"
#include "nets.hpp"

using namespace springnet;
using springnet::testing::Dice;

namespace {

Instrument box_of(const Vector3& middle, const Vector3& size, const Matrix3& axes, double radius) {
  Instrument instrument;
  instrument.first = middle;
  instrument.box = BoxShape{size, axes, radius};
  return instrument;
}

// The signed distance from a convex body is the greatest distance from any of its supporting planes. The greatest is
// that of a face's direction, or of that from a point of the box's core; and none of many by chance may be greater.
double distance_by_planes(const Instrument& box, const Vector3& x, Dice& dice) {
  BoxShape shape = *box.box;
  shape.radius = std::max(shape.radius, 1e-6 * shape.size.minCoeff());  // what sharp edges are rounded by
  const Vector3 core = 0.5 * shape.size - Vector3::Constant(shape.radius);
  const Vector3 place = shape.axes.transpose() * (x - box.first);
  double greatest = -1e9;
  const auto consider = [&](const Vector3& direction) {
    if (direction.isZero(0.0)) return;
    const Vector3 n = direction.normalized();
    greatest = std::max(greatest, n.dot(place) - n.cwiseAbs().dot(core) - shape.radius);
  };
  for (int i = 0; i < 27; ++i) {  // below, between and above each pair of faces
    const Vector3 side(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    consider(side);
    consider((place - side.cwiseProduct(core)).cwiseProduct(side.cwiseAbs()));
  }
  const double found = greatest;
  for (int i = 0; i < 4000; ++i) consider(dice.vector(1.0));
  CHECK(greatest <= found + 1e-15);
  return found;
}

// Of a motion and a turn at once, off the obstacle's middle.
template <class Surface>
Surface with_motion(Surface surface) {
  surface.motion.emplace();
  surface.motion->amplitude = {0.1, -0.2, 0.15};
  surface.motion->frequency = 0.7;
  surface.turn.emplace();
  surface.turn->axis = Vector3(0.6, 0.0, 0.8);
  surface.turn->through = Vector3(0.3, -0.2, 0.4);
  surface.turn->times = {0.0, 1.0, 2.5};
  surface.turn->angles = {0.0, 2.0, -1.0};
  return surface;
}

std::vector<Obstacle> moving_obstacles() {
  Plane plane;
  plane.normal = Vector3(0.36, 0.48, 0.8);
  Instrument capsule;
  capsule.second = {0.4, 0.1, 0.2};
  capsule.radius = 0.3;
  const Matrix3 axes = Eigen::AngleAxisd(0.7, Vector3(0.6, 0.8, 0.0)).toRotationMatrix();
  std::vector<Obstacle> obstacles{Obstacle(with_motion(plane)), Obstacle(with_motion(capsule))};
  for (const double radius : {0.0, 0.1})
    obstacles.emplace_back(with_motion(box_of({0.1, 0, 0}, {0.6, 0.4, 0.3}, axes, radius)));
  return obstacles;
}

}  // namespace

TEST_CASE("the distance from a box is that from its supporting planes, outside and inside") {
  Dice dice;
  for (const double radius : {0.0, 0.05, 0.1}) {
    const Instrument instrument = box_of({0.3, -0.2, 0.5}, {0.8, 0.2, 0.5}, dice.rotation(), radius);
    const Obstacle box(instrument);
    CHECK_FALSE(box.is_plane());
    CHECK_FALSE(box.is_flat());
    int inside = 0;
    for (int k = 0; k < 60; ++k) {
      const Vector3 x = instrument.first + instrument.box->axes * dice.vector(1.0).cwiseProduct(Vector3(0.6, 0.3, 0.5));
      const double gap = box.gap(Pose{}, x);
      inside += gap < 0.0 ? 1 : 0;
      CHECK(std::abs(gap - distance_by_planes(instrument, x, dice)) <= 1e-15);
    }
    CHECK(inside >= 5);
  }
}

TEST_CASE("a box lies on its faces, edges and corners") {
  const Obstacle sharp(box_of({1, 0, 0}, {2, 4, 6}, Matrix3::Identity(), 0.0));
  const Obstacle round(box_of({1, 0, 0}, {2, 4, 6}, Matrix3::Identity(), 0.5));
  const Pose rest;
  for (const Obstacle* box : {&sharp, &round}) {
    CHECK(box->gap(rest, {3, 0.5, 0}) == doctest::Approx(1.0).epsilon(1e-15));
    CHECK(box->normal(rest, {3, 0.5, 0}) == Vector3::UnitX());
    CHECK(box->gap(rest, {1, 0, -3.25}) == doctest::Approx(0.25).epsilon(1e-14));
    CHECK(box->normal(rest, {1, 0, -3.25}) == -Vector3::UnitZ());
    CHECK(box->curvature(rest, {1, 0, -3.25}).isZero(0.0));
    CHECK(box->gap(rest, {1.75, 0, 0}) == doctest::Approx(-0.25).epsilon(1e-14));  // inside, the face x = 2 is nearest
    CHECK(box->normal(rest, {1.75, 0, 0}) == Vector3::UnitX());
    CHECK(box->onto(rest, {1.75, 0, 0}).isApprox(Vector3(2, 0, 0), 1e-15));
  }
  // 3 and 4 beyond an edge, which is rounded by 2e-6, within sqrt(2) - 1 of that of a sharp one. On the surface a
  // rounded edge is a cylinder of its radius.
  CHECK(std::abs(sharp.gap(rest, {5, 6, 0}) - 5.0) <= 1e-6);
  CHECK(sharp.normal(rest, {5, 6, 0}).isApprox(Vector3(0.6, 0.8, 0), 1e-6));
  const Vector3 edge = Vector3(1.5, 1.5, 0) + 0.5 * Vector3(0.6, 0.8, 0);
  CHECK(std::abs(round.gap(rest, edge)) <= 1e-15);
  const Vector3 across(0.8, -0.6, 0);
  CHECK(round.curvature(rest, edge).isApprox(2.0 * across * across.transpose(), 1e-14));
  // A rounded corner is a sphere.
  const Vector3 n = Vector3(1, 2, -2) / 3.0, corner = Vector3(1.5, 1.5, -2.5) + 0.5 * n;
  CHECK(std::abs(round.gap(rest, corner)) <= 1e-15);
  CHECK(round.curvature(rest, corner).isApprox(2.0 * (Matrix3::Identity() - n * n.transpose()), 1e-14));
  // Rounded until nothing flat is left of its edges: a sphere.
  const Obstacle ball(box_of({1, 0, 0}, {2, 2, 2}, Matrix3::Identity(), 1.0));
  CHECK(ball.gap(rest, {1, 3, 4}) == 4.0);
  CHECK(ball.normal(rest, {1, 3, 4}).isApprox(Vector3(0, 0.6, 0.8), 1e-15));
}

TEST_CASE("normals and curvatures are derivatives of the distance, wherever the obstacle has turned to") {
  Dice dice;
  for (const Obstacle& obstacle : moving_obstacles()) {
    for (int k = 0; k < 40; ++k) {
      const Pose pose = obstacle.at(just_after(dice.number(0.0, 2.5)));
      const Vector3 x = pose.from_start(obstacle.origin() + dice.vector(1.0));
      if (obstacle.gap(pose, x) < 0.05) continue;  // the distance is smooth there, up to jumps of its second derivative
      constexpr double step = 1e-6;                // of central differences: step^2, and rounding / step
      const Matrix3 curvature = obstacle.curvature(pose, x);
      double worst = 0.0;
      for (int c = 0; c < 3; ++c) {
        const Vector3 d = step * Vector3::Unit(c);
        const double slope = (obstacle.gap(pose, x + d) - obstacle.gap(pose, x - d)) / (2 * step);
        CHECK(std::abs(obstacle.normal(pose, x)[c] - slope) <= 1e-8);
        const Vector3 turning = (obstacle.normal(pose, x + d) - obstacle.normal(pose, x - d)) / (2 * step);
        worst = std::max(worst, (curvature.col(c) - turning).norm());
      }
      CHECK(worst <= 1e-7);  // third derivatives up to 1 / 0.05^2
      CHECK(std::abs(obstacle.gap(pose, obstacle.onto(pose, x))) <= 1e-15);
    }
  }
}

TEST_CASE("points of an obstacle that moves and turns: place, velocity, acceleration") {
  Dice dice;
  for (const Obstacle& obstacle : moving_obstacles()) {
    CHECK(obstacle.moves());
    CHECK(obstacle.turns());
    for (int k = 0; k < 20; ++k) {
      const double time = dice.number(0.01, 0.99), step = 1e-5;
      const Vector3 start = dice.vector(1.0);
      const auto pose = [&](double t) { return obstacle.at(just_after(t)); };
      const auto place = [&](double t) { return pose(t).from_start(start); };
      const auto velocity = [&](double t) { return pose(t).velocity_at(place(t)); };
      CHECK((pose(time).to_start(place(time)) - start).norm() <= 1e-15);
      // Central differences: step^2 / 6 of third derivatives below 1e3, and rounding / step.
      CHECK((velocity(time) - (place(time + step) - place(time - step)) / (2 * step)).norm() <= 1e-7);
      CHECK((pose(time).acceleration_at(place(time)) - (velocity(time + step) - velocity(time - step)) / (2 * step))
                .norm() <= 1e-7);
    }
  }
}

TEST_CASE("the distance of a moving point from a turning obstacle has the second derivative that is returned") {
  Dice dice;
  for (const Obstacle& obstacle : moving_obstacles()) {
    for (int k = 0; k < 20; ++k) {
      const double time = dice.number(0.1, 0.9), step = 1e-4;
      const Vector3 velocity = dice.vector(1.0), acceleration = dice.vector(1.0);
      Vector3 x = obstacle.at(just_after(time)).from_start(obstacle.origin() + dice.vector(1.0));
      const auto gap = [&](double t) {
        const double s = t - time;
        return obstacle.gap(obstacle.at(just_after(t)), x + s * (velocity + 0.5 * s * acceleration));
      };
      if (gap(time) < 0.1) continue;
      const Pose pose = obstacle.at(just_after(time));
      const Vector3 n = obstacle.normal(pose, x), relative = velocity - pose.velocity_at(x);
      const double first = n.dot(relative);
      const double second =
          n.dot(acceleration - pose.acceleration_at(x)) + obstacle.bias_acceleration(pose, x, relative);
      CHECK(std::abs(first - (gap(time + step) - gap(time - step)) / (2 * step)) <= 1e-5);
      // Where the nearest point goes from a face to an edge within the step the second derivative jumps; no such point
      // is among these. step^2 / 12 of fourth derivatives below 1e5, and rounding / step^2.
      CHECK(std::abs(second - (gap(time + step) - 2 * gap(time) + gap(time - step)) / (step * step)) <= 1e-3);
    }
  }
}

TEST_CASE("seams are where the curvature jumps") {
  const Pose rest;
  const Obstacle box(box_of({1, 0, 0}, {2, 4, 6}, Matrix3::Identity(), 0.5));  // its core: half sizes 0.5, 1.5, 2.5
  CHECK(box.seam(rest, {1.2, 0.4, 3}) == doctest::Approx(-0.3));               // on a face, 0.3 from its edge
  CHECK(box.seam(rest, {1.5, 0.4, 3}) == 0.0);
  CHECK(box.seam(rest, {1.7, 0.4, 2.9}) == doctest::Approx(0.2));
  CHECK(box.seam(rest, {1.7, 1.6, 2.9}) == doctest::Approx(-0.1));  // on a corner
  Instrument rod;
  rod.second = {0, 0, 2};
  CHECK(Obstacle(rod).seam(rest, {1, 0, 0.5}) == 0.5);
  CHECK(Obstacle(rod).seam(rest, {1, 0, 2}) == 0.0);
  CHECK(Obstacle(rod).seam(rest, {0, 0, -1}) == -1.0);
  rod.second = rod.first;
  CHECK(Obstacle(rod).seam(rest, {1, 0, 0}) == std::numeric_limits<double>::infinity());
  CHECK(Obstacle(Plane{}).seam(rest, {1, 0, 0}) == std::numeric_limits<double>::infinity());

  // Along lines beside moving obstacles: the curvature jumps where the seam changes its sign, and nowhere else.
  Dice dice;
  int crossed = 0;
  for (const Obstacle& obstacle : moving_obstacles()) {
    for (int k = 0; k < 40; ++k) {
      const Pose pose = obstacle.at(just_after(dice.number(0.0, 2.5)));
      const Vector3 a = pose.from_start(obstacle.origin() + dice.vector(1.0));
      const Vector3 b = pose.from_start(obstacle.origin() + dice.vector(1.0));
      constexpr int steps = 2000;
      for (int i = 0; i < steps; ++i) {
        const Vector3 x = a + (b - a) * i / steps, y = a + (b - a) * (i + 1) / steps;
        if (obstacle.gap(pose, x) < 0.05 || obstacle.gap(pose, y) < 0.05) continue;
        const double change = (obstacle.curvature(pose, y) - obstacle.curvature(pose, x)).norm();
        const bool crosses = (obstacle.seam(pose, x) < 0.0) != (obstacle.seam(pose, y) < 0.0);
        crossed += crosses ? 1 : 0;
        // Radii from 0.05 m to 3 m: the curvature changes by up to 2 / 0.05^2 m in a step of up to 2 mm; where it
        // jumps, by 1 / 3 m at least, if it is not seen along its axis. Planes have no seam and no curvature.
        if (!crosses) CHECK(change <= 2.0);
        if (crosses) CHECK(change >= 0.2);
      }
    }
  }
  CHECK(crossed > 50);
}

TEST_CASE("the first touch of a box on a straight path") {
  const Obstacle box(box_of({0, 0, 0}, {2, 2, 2}, Matrix3::Identity(), 0.0));
  const Pose rest;
  const auto into = box.first_touch(rest, {-3, 0.5, 0}, rest, {0, 0.5, 0});
  REQUIRE(into);
  CHECK(*into == doctest::Approx(2.0 / 3.0).epsilon(1e-12));
  const auto through = box.first_touch(rest, {-3, -1.5, 0}, rest, {3, 4.5, 0});  // past an edge, both ends outside
  REQUIRE(through);
  CHECK(*through == doctest::Approx(2.0 / 6.0).epsilon(1e-9));
  CHECK_FALSE(box.first_touch(rest, {-3, -0.99, 0}, rest, {3, 5.01, 0}));  // the edge at (-1, 1) passed by 0.007 m
  CHECK_FALSE(box.first_touch(rest, {-3, 0, 0}, rest, {-1.5, 0, 0}));

  // On random paths, against the gap in small steps.
  Dice dice;
  const Obstacle turned(box_of({0.1, 0.2, 0.3}, {0.9, 0.5, 0.7}, dice.rotation(), 0.1));
  int touches = 0;
  for (int k = 0; k < 200; ++k) {
    const Vector3 a = dice.vector(1.5), b = dice.vector(1.5);
    if (turned.gap(rest, a) <= 0.0) continue;
    double min_gap = 1e9, first = 2.0;
    for (int i = 0; i <= 10000 && first > 1.0; ++i) {
      const double gap = turned.gap(rest, a + 1e-4 * i * (b - a));
      min_gap = std::min(min_gap, gap);
      if (gap < 0.0) first = 1e-4 * i;
    }
    if (first > 1.0 && min_gap < 1e-4) continue;  // grazes: the samples are too coarse
    const auto share = turned.first_touch(rest, a, rest, b);
    REQUIRE(share.has_value() == (first <= 1.0));
    if (!share) continue;
    ++touches;
    CHECK(std::abs(*share - first) <= 1e-4);
  }
  CHECK(touches >= 20);
}

TEST_CASE("a box that turns over a point that rests meets it where its edge comes to be") {
  // Half a metre above the middle of a slab 0.2 m thick: its upper face turns up and gets there at 90 degrees less the
  // angle at which the point is on the face.
  Instrument slab = box_of(Vector3::Zero(), {4, 4, 0.2}, Matrix3::Identity(), 0.0);
  slab.turn.emplace();
  slab.turn->axis = -Vector3::UnitY();
  slab.turn->rate = 1.0;
  const Obstacle obstacle(slab);
  const Vector3 x(1.0, 0.0, 0.5);
  // n . x = 0.1 with n = (-sin a, 0, cos a).
  const double angle = std::atan2(0.5, 1.0) - std::asin(0.1 / x.norm());
  CHECK(std::abs(obstacle.gap(obstacle.at(just_after(angle)), x)) <= 1e-15);
  CHECK(obstacle.next_change(0.0) == std::numeric_limits<double>::infinity());
  const double begin = angle - 0.02, end = angle + 0.03;
  const auto share = obstacle.first_touch(obstacle.at(just_after(begin)), x, obstacle.at(just_after(end)), x);
  REQUIRE(share);
  CHECK(std::abs(begin + *share * (end - begin) - angle) <= 0.05 * 0.05);  // straight where the path is an arc
}

TEST_CASE("a surface can be placed although it turns about a point off it") {
  Instrument ball;
  ball.turn.emplace();
  ball.turn->through = Vector3(1, 0, 0);
  ball.turn->rate = 2.0;
  const Obstacle obstacle(ball);
  const Vector3 there(3, -1, 2);
  Pose pose = obstacle.at(just_after(0.7));
  pose.displacement = obstacle.displacement_to(there, 0.7);
  CHECK((pose.from_start(obstacle.origin()) - there).norm() <= 1e-15);
}
