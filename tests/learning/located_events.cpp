// Derivatives of motions whose steps are divided where events are located, against closed forms: the times of the
// events move, too.

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/learn.hpp>
#include <springnet/motion_derivatives.hpp>

#include "learning_nets.hpp"
#include "motion_loss.hpp"
#include "touching_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

const Vector3 up = Vector3::UnitZ();

// A node at this height, with its weight as a load.
constexpr double weight = 9.81, height = 0.5;  // N, m
Network falling(const Vector3& velocity, const Plane& plane, double mass = 1.0) {
  Network net;
  Node node = point({0, 0, height}, mass);
  node.velocity = velocity;
  net.add_node(node);
  net.add_plane(plane);
  Load load;
  load.nodes = {0};
  load.force = {0, 0, -weight};
  net.add_load(load);
  return net;
}
std::vector<LearnedValues> of_fall() {
  return {{Kind::mass, false, "", {0}}, {Kind::load, false, "", {0}}, {Kind::initial_velocity, false, "", {0}}};
}

}  // namespace

// Theta 1/2 is exact where the acceleration is constant.
TEST_CASE(
    "the height of a ball after it has bounced depends on its mass, weight and velocity as the closed form says") {
  for (const double restitution : {0.4, 0.9}) {
    CAPTURE(restitution);
    constexpr double v0 = 0.7, end = 0.6;
    MotionDerivatives motion(
        std::make_shared<const Network>(falling({0.2, 0, v0}, floor_with(smooth, up, restitution))), plugins(),
        located(0.5, 0.02), end, of_fall());
    motion.run(motion.values_of_network());
    REQUIRE(motion.events().size() == 2);  // it touches and leaves
    constexpr double g = weight;
    const double u = std::sqrt(v0 * v0 + 2 * g * height), touched = (v0 + u) / g, after = end - touched;
    const double by_touch = -(restitution * u - g * after), by_u = restitution * after;
    CHECK(motion.positions(motion.step_count())(2, 0) ==
          doctest::Approx(restitution * u * after - 0.5 * g * after * after).epsilon(1e-8));
    const double by_v0 = by_u * v0 / u + by_touch * (1 + v0 / u) / g;
    const double by_g = by_u * height / u + by_touch * (height / (u * g) - touched / g) - 0.5 * after * after;
    const VectorXd gradient = gradient_of_end(motion, 0, 2);
    CHECK(gradient[0] == doctest::Approx(-g * by_g).epsilon(1e-6));  // mass: g = weight / mass
    CHECK(gradient[1] == doctest::Approx(g * by_g).epsilon(1e-6));
    CHECK(gradient[2] == 0.0);
    CHECK(gradient[4] == doctest::Approx(by_v0).epsilon(1e-6));
  }
}

TEST_CASE("where a node comes to rest that falls on a rough floor depends on its velocity as the closed form says") {
  constexpr double vx = 2.0, v0 = 0.3, end = 1.2;
  MotionDerivatives motion(std::make_shared<const Network>(falling({vx, 0, v0}, floor_with(rough))), plugins(),
                           located(0.5, 0.02), end, of_fall());
  motion.run(motion.values_of_network());
  REQUIRE(motion.events().size() == 2);  // it touches and comes to rest
  constexpr double g = weight, mu = rough.coefficient;
  const double u = std::sqrt(v0 * v0 + 2 * g * height), touched = (v0 + u) / g, slides = vx - mu * u;
  REQUIRE(touched + slides / (mu * g) < end);
  CHECK(motion.positions(motion.step_count())(0, 0) ==
        doctest::Approx(vx * touched + 0.5 * slides * slides / (mu * g)).epsilon(1e-6));
  const double by_u = vx / g - slides / g;
  const VectorXd gradient = gradient_of_end(motion, 0, 0);
  CHECK(gradient[2] == doctest::Approx(touched + slides / (mu * g)).epsilon(1e-5));
  CHECK(gradient[4] == doctest::Approx(vx / g + by_u * v0 / u - 0.0).epsilon(1e-5));
  const double by_g = by_u * height / u - vx * touched / g - 0.5 * slides * slides / (mu * g * g);
  CHECK(gradient[1] == doctest::Approx(g * by_g).epsilon(1e-5));
}

TEST_CASE("the way after a rupture depends on stiffness, strength, mass and velocity as the closed form says") {
  constexpr double k = 40.0, strength = 6.0, m = 0.8, v0 = 2.0, end = 0.6;
  Network net;
  Node wall = point({0, 0, 0}), node = point({1, 0, 0}, m);
  wall.fixed = true;
  node.velocity = {v0, 0, 0};
  net.add_node(wall);
  net.add_node(node);
  net.add_spring(0, 1,
                 net.add_material({LawUse{"rupturing", {{"stiffness", k}, {"strength", strength}}}, std::nullopt}));
  const std::vector<LearnedValues> learned{{Kind::spring_parameter, false, "stiffness", {0}},
                                           {Kind::spring_parameter, false, "strength", {0}},
                                           {Kind::mass, false, "", {1}},
                                           {Kind::initial_velocity, false, "", {1}}};
  const auto way = [&](double stiffness, double limit, double mass, double speed) {
    const double omega = std::sqrt(stiffness / mass), stretch = limit / stiffness;
    const double ruptured = std::asin(omega * stretch / speed) / omega;
    return 1.0 + stretch + std::sqrt(speed * speed - omega * omega * stretch * stretch) * (end - ruptured);
  };
  double error[2], by_velocity = 0.0;
  for (const int halving : {0, 1}) {
    MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), located(0.5, 0.01 / (1 << halving)), end,
                             learned);
    motion.run(motion.values_of_network());
    REQUIRE(motion.events().size() == 1);
    const VectorXd gradient = gradient_of_end(motion, 1, 0);
    constexpr double d = 1e-5;
    const double by[] = {(way(k + d, strength, m, v0) - way(k - d, strength, m, v0)) / (2 * d),
                         (way(k, strength + d, m, v0) - way(k, strength - d, m, v0)) / (2 * d),
                         (way(k, strength, m + d, v0) - way(k, strength, m - d, v0)) / (2 * d),
                         (way(k, strength, m, v0 + d) - way(k, strength, m, v0 - d)) / (2 * d)};
    by_velocity = gradient[3];
    error[halving] = 0.0;
    for (Eigen::Index i = 0; i < 4; ++i) error[halving] = std::max(error[halving], std::abs(gradient[i] / by[i] - 1.0));
  }
  // Differences of motions that are not divided go there with the time step; their own derivatives do not.
  const auto stepwise = [&](double step, double speed) {
    Network other = net;
    Node own = other.nodes()[1];
    own.velocity = {speed, 0, 0};
    other.set_node(1, own);
    Simulation motion = simulate(other, method(0.5, newton, step).integrator, step);
    motion.advance_to(end);
    return motion.position(1).x();
  };
  constexpr double far = 0.1;
  double away[2];
  for (const int finer : {0, 1}) {
    const double step = finer == 0 ? 0.01 : 0.0001;
    const double difference = (8.0 * (stepwise(step, v0 + far) - stepwise(step, v0 - far)) -
                               (stepwise(step, v0 + 2 * far) - stepwise(step, v0 - 2 * far))) /
                              (12.0 * far);
    away[finer] = std::abs(difference / by_velocity - 1.0);
  }
  CHECK(away[1] < 5e-3);
  CHECK(away[0] > 10.0 * away[1]);
  CAPTURE(error[0]);
  CHECK(error[1] < 2e-4);                       // of the method
  CHECK(std::log2(error[0] / error[1]) > 1.7);  // which is of second order
}

TEST_CASE("the derivative is continuous where an event moves from one step to the next") {
  // The ball reaches the floor at the end of step 20 with the velocity in the middle.
  constexpr double g = weight, step = 0.02, restitution = 0.7;
  const double at_boundary = 0.5 * g * 20 * step - height / (20 * step);
  const auto derivative = [&](double v0, bool locates) {
    SimulationOptions options = locates ? located(0.5, step) : method(0.5, newton, step);
    MotionDerivatives motion(std::make_shared<const Network>(falling({0, 0, v0}, floor_with(smooth, up, restitution))),
                             plugins(), options, 0.6, of_fall());
    motion.run(motion.values_of_network());
    return gradient_of_end(motion, 0, 2)[4];
  };
  constexpr double d = 1e-6;
  CHECK(derivative(at_boundary - d, true) ==
        doctest::Approx(derivative(at_boundary + d, true)).epsilon(1e-4 * d / 1e-6));
  CHECK(std::abs(derivative(at_boundary - d, false) / derivative(at_boundary + d, false) - 1.0) > 1e-2);
}

// A search that begins with a touch in other steps. Steps that are not divided have another motion, and no derivative
// of the time of the touch.
TEST_CASE("a search finds the values of a motion whose touch moves between steps") {
  constexpr double step = 0.02;
  Simulation motion(falling({0, 0, 0.7}, floor_with(smooth, up, 0.8)), plugins(), located(0.5, step));
  const Observations seen = observe(motion, 40, {0});
  const Network start = falling({0, 0, 0.4}, floor_with(smooth, up, 0.8), 1.15);
  const auto error = [&](const SimulationOptions& options) {
    LearnOptions search;
    search.stages = 1;
    const LearnedNet learned = learn(
        {experiment(start, options, seen)}, plugins(),
        {Learnable{{Kind::mass, false, "", {0}}, false}, Learnable{{Kind::initial_velocity, false, "", {0}}, false}},
        search);
    double greatest = 0.0;
    for (const LearnedParameter& each : learned.parameters)
      greatest = std::max(greatest, std::abs(each.value - (each.kind == Kind::mass ? 1.0
                                                           : each.axis == 2        ? 0.7
                                                                                   : 0.0)));
    return greatest;
  };
  CHECK(error(located(0.5, step)) < 1e-6);
  CHECK(error(method(0.5, newton, step)) > 1e-3);
}
