// Obstacles, motions and rigid connections: what a network takes and what it refuses.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include <springnet/error.hpp>
#include <springnet/network.hpp>

#include "facts.hpp"
#include "not_finite.hpp"

using springnet::Friction;
using springnet::Instrument;
using springnet::Motion;
using springnet::Network;
using springnet::NodeIndex;
using springnet::Plane;
using springnet::Turn;
using springnet::Vector3;
using springnet::testing::inf;
using springnet::testing::nan_value;

namespace {

// Four nodes at the corners of a square of 1 m.
Network square() {
  Network network;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(0, 1, 0)}) {
    network.add_node({p, Vector3(1, 2, 3), 2.0, 0, false});
  }
  return network;
}

Motion table(std::vector<double> times, std::vector<Vector3> displacements) {
  Motion motion;
  motion.times = std::move(times);
  motion.displacements = std::move(displacements);
  return motion;
}

const Motion lift = table({0, 1}, {Vector3::Zero(), Vector3::UnitZ()});

Motion sinusoid(const Vector3& amplitude, double frequency) {
  Motion motion;
  motion.amplitude = amplitude;
  motion.frequency = frequency;
  return motion;
}

// The change is refused with an Error(input) that has these facts.
template <class Change>
void square_refused(const Change& change, const std::string& words) {
  Network network = square();
  std::string message;
  try {
    change(network);
  } catch (const springnet::Error& error) {
    CHECK(error.kind() == springnet::ErrorKind::input);
    message = error.what();
  }
  CAPTURE(message);
  CAPTURE(words);
  CHECK(springnet::testing::has_facts(message, words));
  // What was refused left nothing behind.
  CHECK(network.planes().empty());
  CHECK(network.instruments().empty());
  CHECK(network.moves().empty());
  CHECK(network.rigids().empty());
  for (const springnet::Node& node : network.nodes()) CHECK_FALSE(node.fixed);
}

void motion_refused(const Motion& motion, const std::string& words) {
  square_refused([&](Network& n) { n.add_move({{0, 1}, motion}); }, "a motion of nodes");
  square_refused([&](Network& n) { n.add_move({{0, 1}, motion}); }, words);
  square_refused(
      [&](Network& n) {
        n.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ(), {}, motion});
      },
      "the motion of plane 'floor'");
  square_refused([&](Network& n) { n.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ(), {}, motion}); }, words);
  square_refused(
      [&](Network& n) {
        n.add_instrument({"", Vector3::Zero(), Vector3::Zero(), 1.0, {}, motion});
      },
      "the motion of an instrument");
}

}  // namespace

TEST_CASE("a plane keeps its friction and its motion") {
  Network network = square();
  network.add_plane({"floor", Vector3::Zero(), {0, 0, 2}, {Friction::Kind::coulomb, 0.4}, lift});
  network.add_plane({"wall", Vector3::Zero(), {1, 0, 0}});
  CHECK(network.planes()[0].normal == Vector3::UnitZ());
  CHECK(network.planes()[0].friction.kind == Friction::Kind::coulomb);
  CHECK(network.planes()[0].friction.coefficient == 0.4);
  REQUIRE(network.planes()[0].motion.has_value());
  CHECK(network.planes()[0].motion->times == lift.times);
  CHECK(network.planes()[1].friction.kind == Friction::Kind::held);
  CHECK_FALSE(network.planes()[1].motion.has_value());
}

TEST_CASE("instruments: spheres and capsules") {
  Network network = square();
  network.add_instrument({"ball", {1, 2, 3}, {1, 2, 3}, 0.5, {Friction::Kind::none, 0.0}, std::nullopt});
  network.add_instrument({"probe", {0, 0, 1}, {0, 0, 5}, 0.1, {}, sinusoid({0, 0, 1}, 2.0)});
  REQUIRE(network.instruments().size() == 2);
  CHECK(network.instruments()[0].friction.kind == Friction::Kind::none);
  CHECK(network.instruments()[1].second == Vector3(0, 0, 5));
  CHECK(network.instruments()[1].motion->frequency == 2);

  const auto with_radius = [](double radius) {
    return [=](Network& n) { n.add_instrument({"ball", Vector3::Zero(), Vector3::Zero(), radius, {}, std::nullopt}); };
  };
  square_refused(with_radius(0), "instrument 'ball' | radius | above 0 m | is 0");
  square_refused(with_radius(-1), "is -1");
  square_refused(with_radius(inf), "is inf");
  square_refused(with_radius(nan_value), "is nan");
  square_refused(
      [](Network& n) {
        n.add_instrument({"", {nan_value, 0, 0}, Vector3::Zero(), 1.0, {}, std::nullopt});
      },
      "end of an instrument");
  square_refused(
      [](Network& n) {
        n.add_instrument({"", Vector3::Zero(), {0, inf, 0}, 1.0, {}, std::nullopt});
      },
      "end of an instrument");
}

TEST_CASE("instruments: boxes") {
  Network network = square();
  Instrument block;
  block.name = "block";
  block.first = {1, 2, 3};
  block.second = {nan_value, 0, 0};  // not read of a box
  block.radius = -1;
  block.box.emplace();
  network.add_instrument(block);
  CHECK(network.instruments()[0].box->size == Vector3::Ones());
  CHECK(network.instruments()[0].box->axes == Eigen::Matrix3d::Identity());
  // Axes that rounding has left a little off are made a rotation.
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(0.4, Vector3(0, 0.6, 0.8)).toRotationMatrix();
  block.name = "turned";
  block.box->axes = turned + Eigen::Matrix3d::Constant(1e-11);
  block.box->radius = 0.5;  // half of its size: a ball
  network.add_instrument(block);
  const Eigen::Matrix3d& axes = network.instruments()[1].box->axes;
  CHECK((axes.transpose() * axes).isIdentity(1e-15));
  CHECK(axes.isApprox(turned, 1e-10));

  const auto box_refused = [](const Vector3& size, const Eigen::Matrix3d& axes_given, double radius,
                              const char* words) {
    square_refused(
        [&](Network& n) {
          Instrument instrument;
          instrument.name = "block";
          instrument.box = {size, axes_given, radius};
          n.add_instrument(instrument);
        },
        words);
  };
  const Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
  box_refused({1, 0, 1}, upright, 0, "instrument 'block' | size | above 0 m | [1, 0, 1]");
  box_refused({1, -1, 1}, upright, 0, "is [1, -1, 1]");
  box_refused({1, nan_value, 1}, upright, 0, "is [1, nan, 1]");
  box_refused({inf, 1, 1}, upright, 0, "is [inf, 1, 1]");
  box_refused({1, 1, 1}, 2 * upright, 0, "axes | rotation");
  box_refused({1, 1, 1}, -upright, 0, "right-handed");
  box_refused({1, 1, 1}, nan_value * upright, 0, "axes | rotation");
  box_refused({2, 1, 3}, upright, 0.51, "radius | 0.5 m | 0.51");
  box_refused({1, 1, 1}, upright, -0.1, "is -0.1 m");
  box_refused({1, 1, 1}, upright, nan_value, "is nan m");
  square_refused(
      [](Network& n) {
        Instrument instrument;
        instrument.first = {0, inf, 0};
        instrument.box.emplace();
        n.add_instrument(instrument);
      },
      "middle of a box");
}

TEST_CASE("obstacles that turn") {
  Turn turn;
  turn.axis = {0, 3, 4};
  turn.rate = 2;
  Network network = square();
  Plane plane;
  plane.turn = turn;
  network.add_plane(plane);
  CHECK(network.planes()[0].turn->axis.isApprox(Vector3(0, 0.6, 0.8), 1e-15));
  CHECK_FALSE(network.planes()[0].turn->through.has_value());
  Instrument ball;
  ball.turn = turn;
  ball.turn->through = Vector3(1, 2, 3);
  ball.turn->rate = 0;
  ball.turn->times = {0, 1};
  ball.turn->angles = {0, -3};
  network.add_instrument(ball);
  CHECK(network.instruments()[0].turn->axis.isApprox(Vector3(0, 0.6, 0.8), 1e-15));
  CHECK(network.instruments()[0].turn->through == Vector3(1, 2, 3));

  const auto turn_refused = [](const Turn& wrong, const char* words) {
    square_refused(
        [&](Network& n) {
          Plane floor;
          floor.name = "floor";
          floor.turn = wrong;
          n.add_plane(floor);
        },
        std::string("turn | plane 'floor' | ") + words);
    square_refused(
        [&](Network& n) {
          Instrument instrument;
          instrument.turn = wrong;
          n.add_instrument(instrument);
        },
        std::string("turn | instrument | ") + words);
  };
  turn_refused({}, "table | rate");
  Turn wrong = turn;
  wrong.axis = Vector3::Zero();
  turn_refused(wrong, "axis | [0, 0, 0]");
  wrong.axis = {0, inf, 0};
  turn_refused(wrong, "axis | [0, inf, 0]");
  wrong = turn;
  wrong.through = Vector3(0, nan_value, 0);
  turn_refused(wrong, "point | axis | [0, nan, 0]");
  wrong = turn;
  wrong.rate = nan_value;
  turn_refused(wrong, "rate | nan rad/s");
  wrong = turn;
  wrong.from = -inf;
  turn_refused(wrong, "start | minus infinity");
  wrong = turn;
  wrong.from = 2;
  wrong.until = 1;
  turn_refused(wrong, "from 2 s | until 1 s");
  wrong = turn;
  wrong.times = {0, 1};
  wrong.angles = {0, 1};
  turn_refused(wrong, "a table | a rate");
  wrong.rate = 0;
  wrong.angles = {0};
  turn_refused(wrong, "2 times | 1 angles");
  wrong.angles = {0, inf};
  turn_refused(wrong, "angle | entry 1 | inf");
  wrong.angles = {0, 1};
  wrong.times = {1, 1};
  turn_refused(wrong, "times | increase");
  wrong.times = {0, 1};
  wrong.interpolation = static_cast<Motion::Interpolation>(9);
  turn_refused(wrong, "unknown interpolation 9 | linear or smooth");
}

TEST_CASE("restitution is 0 to 1") {
  Network network = square();
  Plane plane;
  CHECK(plane.restitution == 0);
  plane.restitution = 1;
  network.add_plane(plane);
  CHECK(network.planes()[0].restitution == 1);
  for (const double restitution : {-0.1, 1.1, nan_value}) {
    square_refused(
        [&](Network& n) {
          Plane floor;
          floor.restitution = restitution;
          n.add_plane(floor);
        },
        "plane | restitution | 0 to 1");
    square_refused(
        [&](Network& n) {
          Instrument instrument;
          instrument.restitution = restitution;
          n.add_instrument(instrument);
        },
        "instrument | restitution | 0 to 1");
  }
}

TEST_CASE("names of obstacles are unique among planes and instruments") {
  Network network = square();
  network.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  Instrument tip;
  tip.name = "tip";
  network.add_instrument(tip);
  CHECK_THROWS_WITH_AS(network.add_instrument(tip), doctest::Contains("instruments 'tip'"), springnet::Error);
  CHECK_THROWS_WITH_AS(network.add_plane({"tip", Vector3::Zero(), Vector3::UnitZ()}),
                       doctest::Contains("plane 'tip' and an instrument 'tip'"), springnet::Error);
  tip.name = "floor";
  CHECK_THROWS_WITH_AS(network.add_instrument(tip), doctest::Contains("plane 'floor' and an instrument 'floor'"),
                       springnet::Error);
  // Several may have none.
  tip.name = "";
  network.add_instrument(tip);
  network.add_instrument(tip);
  network.add_plane({"", Vector3::Zero(), Vector3::UnitZ()});
  CHECK(network.instruments().size() == 3);
  CHECK(network.planes().size() == 2);
}

TEST_CASE("coefficients of friction are at least 0") {
  for (const double coefficient : {-0.1, nan_value, inf}) {
    square_refused(
        [&](Network& n) {
          n.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ(), {Friction::Kind::coulomb, coefficient}});
        },
        "plane 'floor' | friction | at least 0");
    square_refused(
        [&](Network& n) {
          n.add_instrument(
              {"", Vector3::Zero(), Vector3::Zero(), 1.0, {Friction::Kind::coulomb, coefficient}, std::nullopt});
        },
        "instrument | friction");
  }
}

TEST_CASE("nodes that move count as fixed") {
  Network network = square();
  network.add_move({{2, 0, 2}, lift});
  network.add_move({{1}, sinusoid(Vector3::UnitX(), 3)});
  REQUIRE(network.moves().size() == 2);
  CHECK(network.moves()[0].nodes == std::vector<NodeIndex>{0, 2});
  for (const NodeIndex node : {0u, 1u, 2u}) {
    CHECK(network.nodes()[node].fixed);
    CHECK(network.nodes()[node].velocity == Vector3::Zero());
  }
  CHECK_FALSE(network.nodes()[3].fixed);

  // It stays fixed when it is changed later.
  springnet::Node heavier = network.nodes()[0];
  heavier.mass = 9;
  heavier.fixed = false;
  heavier.velocity = Vector3::UnitX();
  network.set_node(0, heavier);
  CHECK(network.nodes()[0].mass == 9);
  CHECK(network.nodes()[0].fixed);
  CHECK(network.nodes()[0].velocity == Vector3::Zero());
  network.fix(0);

  CHECK_THROWS_WITH_AS(network.add_move({{3, 2}, lift}), doctest::Contains("node 2"), springnet::Error);
  CHECK_FALSE(network.nodes()[3].fixed);
  square_refused([](Network& n) { n.add_move({{0, 4}, lift}); }, "node 4 | only 4");
}

TEST_CASE("motions that are refused") {
  motion_refused({}, "table | sinusoid | amplitude");
  motion_refused(sinusoid(Vector3::Zero(), 2), "table | sinusoid | amplitude");
  Motion both = lift;
  both.amplitude = Vector3::UnitX();
  both.frequency = 1;
  motion_refused(both, "a table | a sinusoid");

  motion_refused(table({0, 1, 2}, {Vector3::Zero(), Vector3::Zero()}), "3 times | 2 displacements");
  motion_refused(table({}, {Vector3::Zero()}), "0 times | 1 displacements");
  motion_refused(table({1}, {Vector3::Zero()}), "two entries | has 1");
  motion_refused(table({0, 0}, {Vector3::Zero(), Vector3::UnitX()}), "increase | entry 0 | entry 1 | 0 s");
  motion_refused(table({0, 2, 1}, {Vector3::Zero(), Vector3::UnitX(), Vector3::Zero()}),
                 "entry 1 | 2 s | entry 2 | 1 s");
  motion_refused(table({0, inf}, {Vector3::Zero(), Vector3::UnitX()}), "entry 1 | infinity");
  motion_refused(table({nan_value, 1}, {Vector3::Zero(), Vector3::UnitX()}), "entry 0 | not a number");
  motion_refused(table({0, 1}, {Vector3::Zero(), {0, nan_value, 0}}), "entry 1 | [0, nan, 0]");
  Motion unknown = table({0, 1}, {Vector3::Zero(), Vector3::UnitX()});
  unknown.interpolation = static_cast<Motion::Interpolation>(9);
  motion_refused(unknown, "unknown interpolation 9 | linear or smooth");

  motion_refused(sinusoid({0, 0, inf}, 1), "amplitude | [0, 0, inf]");
  for (const double frequency : {0.0, -2.0, nan_value, inf}) {
    motion_refused(sinusoid(Vector3::UnitX(), frequency), "frequency | above 0 Hz");
  }
  Motion wrong = sinusoid(Vector3::UnitX(), 1);
  wrong.phase = nan_value;
  motion_refused(wrong, "phase | nan");
  wrong.phase = 0;
  wrong.from = -inf;
  motion_refused(wrong, "start | minus infinity");
  wrong.from = 2;
  wrong.until = 2;
  motion_refused(wrong, "from 2 s | until 2 s");
}

TEST_CASE("rigid connections: the length is the distance") {
  Network network = square();
  CHECK(network.add_rigid(0, 1) == 0);
  CHECK(network.add_rigid(2, 0) == 1);
  CHECK(network.add_rigid(2, 3, 1.0) == 2);
  CHECK(network.add_rigid(1, 2, 1.0 + 0.9e-8) == 3);  // within the accuracy to which it is kept
  CHECK(network.add_rigid(0, 3, 1.0 - 0.9e-8) == 4);
  REQUIRE(network.rigids().size() == 5);
  CHECK(network.rigids()[0].length == 1);
  CHECK(network.rigids()[1].first == 2);
  CHECK(network.rigids()[1].second == 0);
  CHECK(network.rigids()[1].length == doctest::Approx(std::sqrt(2.0)).epsilon(1e-15));  // one rounding
  CHECK(network.rigids()[3].length == 1.0 + 0.9e-8);

  CHECK_THROWS_WITH_AS(network.add_rigid(0, 2), doctest::Contains("node 0 and node 2"), springnet::Error);
  CHECK(network.rigids().size() == 5);
}

TEST_CASE("a node that is joined rigidly keeps its distances") {
  Network network = square();
  network.add_rigid(0, 1);
  springnet::Node node = network.nodes()[1];
  node.mass = 5;
  node.position = Vector3(0, 1, 0);  // as far from node 0
  network.set_node(1, node);
  CHECK(network.nodes()[1].mass == 5);
  node.position = Vector3(0, 2, 0);
  CHECK_THROWS_WITH_AS(network.set_node(1, node), doctest::Contains("node 1 cannot be placed at [0, 2, 0]"),
                       springnet::Error);
  node = network.nodes()[3];
  node.position = Vector3(7, 7, 7);
  network.set_node(3, node);
  CHECK(network.nodes()[3].position == Vector3(7, 7, 7));
}

TEST_CASE("rigid connections that are refused") {
  square_refused([](Network& n) { n.add_rigid(0, 4); }, "rigid connection | node 0 | node 4 | only 4");
  square_refused([](Network& n) { n.add_rigid(2, 2); }, "rigid connection | node 2");
  for (const double length : {0.0, -1.0, nan_value, inf}) {
    square_refused([&](Network& n) { n.add_rigid(0, 1, length); }, "length | above 0 m");
  }
  square_refused([](Network& n) { n.add_rigid(0, 1, 2.0); }, "node 0 | node 1 | 2 m | 1 m");
  square_refused([](Network& n) { n.add_rigid(0, 1, 1.0 + 1.1e-8); }, "apart");
  square_refused(
      [](Network& n) {
        n.add_node({Vector3(1, 0, 0), Vector3::Zero(), 1, 0, false});
        n.add_rigid(1, 4);
      },
      "node 1 | node 4 | length zero | [1, 0, 0]");
}
