// Derivatives of motions whose located events are those of rigidly connected nodes: the impact moves all of them, and
// what they weigh decides when one leaves.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/learn.hpp>
#include <springnet/motion_derivatives.hpp>

#include "derivative_check.hpp"
#include "learning_nets.hpp"
#include "motion_loss.hpp"
#include "touching_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

const Vector3 upwards = Vector3::UnitZ();

// A tetrahedron of six connections at this height that carries a node on springs.
Network carried_at(double height, const Vector3& velocity, const Plane& plane, std::uint64_t seed) {
  Network net;
  Dice dice(seed);
  for (const Vector3& at : {Vector3(0, 0, 0), Vector3(0.3, 0, 0.06), Vector3(0, 0.4, 0.11), Vector3(0.1, 0.1, 0.5)})
    net.add_node(point(at + dice.in_box(0.02) + height * upwards, dice.between(0.5, 2.0), velocity));
  for (NodeIndex a = 0; a < 4; ++a)
    for (NodeIndex b = a + 1; b < 4; ++b) net.add_rigid(a, b);
  const MaterialIndex soft = net.add_material(damped(50.0, 0.5));
  net.add_node(point({0.15, 0.12, 0.9 + height}, 1.5, velocity));
  net.add_spring(3, 4, soft);
  net.add_spring(1, 4, soft);
  net.add_spring(2, 4, soft);
  net.set_gravity({0, 0, -9.81});
  net.add_plane(plane);
  return net;
}

// All values of it but the start velocities of what is rigid.
std::vector<LearnedValues> of_carried(const Network& net) {
  std::vector<LearnedValues> result = values_of(net);
  result.back().members = {4};
  return result;
}

// Bodies that hit, and friction that holds them, change within the steps of differences: events may be found in another
// order.
const Differences steep{1e-5, 5e-7, std::size_t{1} << 30, false};

SimulationOptions rigid_steps(double theta, double step) {
  SimulationOptions options = located(theta, step, wavefront);
  options.integrator.parameters["force_tolerance"] = 3e-10;
  return options;
}

// A rod in a vertical plane, node 0 below and to the left, that falls without turning and bounces on a smooth floor.
struct Rod {
  double first, second, gravity;  // kg, kg, m/s^2
  static constexpr double length = 0.5, angle = 0.4, height = 0.1, speed = -0.4, across = 0.3, restitution = 0.6;

  // Where node 0 is at a time after it has bounced, x and z.
  [[nodiscard]] std::pair<double, double> at(double time) const {
    const double mass = first + second, inertia = first * second / mass * length * length;
    const double arm = length * second / mass;  // from node 0 to the centre of mass
    const double touch = (speed + std::sqrt(speed * speed + 2 * gravity * height)) / gravity;
    const double falls = speed - gravity * touch, lever = arm * std::cos(angle);
    const double impulse = -(1 + restitution) * falls / (1 / mass + lever * lever / inertia);
    const double turns = -impulse * lever / inertia, after = time - touch, turned = angle + turns * after;
    const double z = arm * std::sin(angle) + (falls + impulse / mass) * after - gravity * after * after / 2;
    return {arm * std::cos(angle) + across * time - arm * std::cos(turned), z - arm * std::sin(turned)};
  }
};

}  // namespace

TEST_CASE("a rigid rod that bounces on its end moves on as its masses and gravity tell in closed form") {
  constexpr double end = 0.15;
  const Rod rod{0.8, 1.4, 9.81};
  Network net;
  const Vector3 velocity(Rod::across, 0, Rod::speed);
  net.add_node(point({0, 0, Rod::height}, rod.first, velocity));
  net.add_node(point(Vector3(std::cos(Rod::angle), 0, std::sin(Rod::angle)) * Rod::length + Rod::height * upwards,
                     rod.second, velocity));
  net.add_rigid(0, 1);
  net.set_gravity({0, 0, -rod.gravity});
  net.add_plane(floor_with(smooth, upwards, Rod::restitution));
  double errors[2];
  for (const int halving : {0, 1}) {
    MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), rigid_steps(0.5, 0.0025 / (1 << halving)),
                             end, {{Kind::mass, false, "", {0, 1}}, {Kind::gravity, false, "", {2}}});
    motion.run(motion.values_of_network());
    REQUIRE(motion.events().size() == 2);  // it touches and leaves
    errors[halving] = 0.0;
    for (const Eigen::Index axis : {0, 2}) {
      const auto place = [&](double first, double second, double gravity) {
        const auto [x, z] = Rod{first, second, gravity}.at(end);
        return axis == 0 ? x : z;
      };
      CHECK(motion.positions(motion.step_count())(axis, 0) ==
            doctest::Approx(place(rod.first, rod.second, rod.gravity)).epsilon(1e-4));
      constexpr double d = 1e-5;
      const auto& [m, n, g] = rod;
      const double by[] = {(place(m + d, n, g) - place(m - d, n, g)) / (2 * d),
                           (place(m, n + d, g) - place(m, n - d, g)) / (2 * d),
                           -(place(m, n, g + d) - place(m, n, g - d)) / (2 * d)};
      const VectorXd gradient = gradient_of_end(motion, 0, axis);
      for (Eigen::Index i = 0; i < 3; ++i) errors[halving] = std::max(errors[halving], std::abs(gradient[i] - by[i]));
    }
  }
  // A rotation is of second order with theta 1/2.
  CHECK(errors[0] < 2e-4);
  CHECK(errors[0] / errors[1] == doctest::Approx(4.0).epsilon(0.05));
}

TEST_CASE("rigid bodies that touch, bounce, slide and rest have the motion of their events in the derivatives") {
  for (const Friction& friction : {smooth, rough, held})
    for (const double theta : {1.0, 0.5})
      for (const double restitution : {0.0, 0.5}) {
        CAPTURE(static_cast<int>(friction.kind));
        CAPTURE(theta);
        CAPTURE(restitution);
        const Network net = carried_at(0.04, {0.5, 0.1, -0.6}, floor_with(friction, {0.1, -0.05, 1.0}, restitution), 4);
        const bool rests = friction.kind == Friction::Kind::coulomb;
        CHECK(check_derivatives(net, rigid_steps(theta, 0.005), 0.12, of_carried(net), steep) >=
              (restitution > 0.0 || rests ? 2 : 1));
      }
}

TEST_CASE("events of rigid bodies on surfaces that move, and of those that loads lift, move as in the derivatives") {
  // With the seed of each: its friction, theta and restitution.
  struct Case {
    std::uint64_t seed;
    bool is_lifted;
    std::size_t least;  // of events
    double accuracy = steep.accuracy;
  };
  for (const Case& each : {Case{12, false, 5},
                           {15, false, 10},
                           {18, false, 10},
                           {19, false, 10},
                           {20, false, 10},
                           {22, false, 10},
                           {24, true, 5},
                           {25, true, 4},
                           {29, true, 5},
                           {31, true, 5}}) {
    CAPTURE(each.seed);
    Dice dice(100 + each.seed);
    const Friction friction = std::array{smooth, rough, held}[each.seed % 3];
    const double theta = each.seed / 3 % 2 == 1 ? 0.5 : 1.0, restitution = each.seed / 6 % 2 == 1 ? 0.5 : 0.0;
    const double vx = dice.between(-0.8, 0.8), vy = dice.between(-0.8, 0.8), vz = dice.between(-1.0, -0.3);
    const double height = dice.between(0.02, 0.06);
    Network net =
        carried_at(height, {vx, vy, vz}, floor_with(friction, {0.1, -0.05, 1.0}, restitution), 100 + each.seed);
    if (each.is_lifted) {
      Load lifts;
      lifts.nodes = {3};
      lifts.force = {3.0, 1.0, 40.0};
      lifts.course.frequency = 6.0;
      net.add_load(lifts);
    } else {
      Instrument ball;
      ball.name = "ball";
      ball.radius = 0.2;
      ball.first = ball.second = Vector3(0.55, 0.05, 0.2 + height);
      ball.friction = friction;
      ball.restitution = restitution;
      ball.motion = Motion{};
      ball.motion->amplitude = {-0.3, 0.01, 0.03};
      ball.motion->frequency = 1.5;
      ball.turn = Turn{};
      ball.turn->axis = {0.2, 1.0, 0.0};
      ball.turn->rate = 0.7;
      net.add_instrument(ball);
    }
    Differences differences = steep;
    differences.accuracy = each.accuracy;
    CHECK(check_derivatives(net, rigid_steps(theta, 0.005), 0.25, of_carried(net), differences) >= each.least);
  }
}

TEST_CASE(
    "the times at which the nodes of a rigid body are lifted off a floor, one by one, move with all of its forces") {
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    Network net;
    for (const Vector3& at : {Vector3(0, 0, 0), Vector3(0.3, 0.02, 0), Vector3(0.05, 0.4, 0), Vector3(0.15, 0.1, 0.5)})
      net.add_node(point(at, 0.5 + at.x() + at.z()));
    for (NodeIndex a = 0; a < 4; ++a)
      for (NodeIndex b = a + 1; b < 4; ++b) net.add_rigid(a, b);
    const MaterialIndex soft = net.add_material(damped(50.0, 0.5));
    net.add_node(point({0.2, 0.1, 0.9}, 1.5));
    for (const NodeIndex k : {1, 2, 3}) net.add_spring(k, 4, soft);
    net.set_gravity({0, 0, -9.81});
    net.add_plane(floor_with(smooth));
    Load lifts;
    lifts.nodes = {3};
    lifts.force = {6.0, 4.0, 60.0};
    lifts.course.frequency = 1.5;
    net.add_load(lifts);
    CHECK(check_derivatives(net, rigid_steps(theta, 0.005), 0.15, of_carried(net), steep) >= 2);
  }
}

TEST_CASE("events of rigid bodies that springs with memory join are differentiated within any memory") {
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    Network net = carried_at(0.04, {0.5, 0.1, -0.6}, floor_with(smooth, {0.1, -0.05, 1.0}, 0.5), 4);
    net.add_spring(
        0, 4, net.add_material({LawUse{"maxwell", {{"stiffness", 80.0}, {"relaxation_time", 0.05}}}, std::nullopt}));
    std::vector<LearnedValues> learned = of_carried(net);
    std::erase_if(learned, [](const LearnedValues& each) {
      return each.kind == Kind::viscosity_parameter || each.kind == Kind::rest_length;
    });
    Differences within = steep;
    CHECK(check_derivatives(net, rigid_steps(theta, 0.00125), 0.12, learned, within) >= 2);
    within.memory = std::size_t{30} << 10;
    CHECK(check_derivatives(net, rigid_steps(theta, 0.00125), 0.12, learned, within) >= 2);
  }
}

TEST_CASE("a stiffness and the masses of a dumbbell that bounces and tumbles are found from its motion") {
  const auto dumbbell = [](double second, double stiffness) {
    Network net;
    net.add_node(point({0, 0, 0.2}, 0.4));
    net.add_node(point({0.3, 0.02, 0.28}, second));
    net.add_node(point({0.1, 0.05, 0.6}, 0.5));
    net.add_rigid(0, 1);
    const MaterialIndex soft = net.add_material(damped(stiffness, 0.2));
    net.add_spring(0, 2, soft);
    net.add_spring(1, 2, soft);
    net.set_gravity({0, 0, -9.81});
    net.add_plane(floor_with(held, upwards, 0.5));
    return net;
  };
  const SimulationOptions options = located(0.5, 0.005);
  Simulation real(dumbbell(0.9, 60.0), plugins(), options);
  const Observations seen = observe(real, 90, from_to(0, 3));
  REQUIRE(std::count_if(real.events().begin(), real.events().end(),
                        [](const Event& each) { return each.kind == Event::Kind::touched; }) >= 4);
  const LearnedNet learned =
      learn({experiment(dumbbell(0.7, 50.0), options, seen)}, plugins(),
            {{{Kind::spring_parameter, false, "stiffness", {0, 1}}, true}, {{Kind::mass, false, "", {0, 1, 2}}}});
  CAPTURE(learned.reason);
  // To what steps leave unbalanced.
  const double right[] = {60.0, 0.4, 0.9, 0.5};
  REQUIRE(learned.parameters.size() == 5);
  CHECK(learned.parameters[0].value == doctest::Approx(right[0]).epsilon(1e-6));
  for (std::size_t k = 2; k < 5; ++k) CHECK(learned.parameters[k].value == doctest::Approx(right[k - 1]).epsilon(1e-6));
}
