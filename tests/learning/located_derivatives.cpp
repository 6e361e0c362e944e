// Derivatives of motions whose steps are divided where events are located, against differences of the motions.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/motion_derivatives.hpp>

#include "derivative_check.hpp"
#include "motion_loss.hpp"
#include "torn_net.hpp"
#include "touching_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// Steps divided at events settle part by part; what each leaves moves the time of the next.
constexpr Differences differences{3e-5, 1e-5};

// Its cut is within a step.
Network torn_within_step() { return torn(0.2037, false); }
std::vector<LearnedValues> of_torn(const Network& net) {
  const auto springs = static_cast<std::uint32_t>(net.springs().size());
  return {{Kind::spring_parameter, false, "stiffness", all(springs)},
          {Kind::spring_parameter, false, "strength", all(springs)},
          {Kind::viscosity_parameter, false, "damping", all(springs)},
          {Kind::spring_parameter, true, "stiffness", {0}},
          {Kind::rest_length, false, "", all(springs)},
          {Kind::mass, false, "", {1, 4, 7}},
          {Kind::initial_velocity, false, "", {1, 2, 3}}};
}

}  // namespace

TEST_CASE("the gradient of a body that falls on a plane has the motion of the events in it") {
  for (const Friction& friction : {held, smooth, rough})
    for (const double theta : {1.0, 0.5})
      for (const double restitution : {0.0, 0.5}) {
        CAPTURE(static_cast<int>(friction.kind));
        CAPTURE(theta);
        CAPTURE(restitution);
        Network net = block_at({0, 0, 0.1}, {0.4, 0.2, -0.5}, 6);
        net.add_plane(floor_with(friction, {0.2, -0.1, 1.0}, restitution));
        CHECK(check_derivatives(net, located(theta, 0.01), 0.22, values_of(net), differences) > 3);
      }
}

TEST_CASE("events at the same time, and at the end of a step, are part of the derivatives") {
  for (const Friction::Kind kind : {Friction::Kind::none, Friction::Kind::held})
    for (const double theta : {1.0, 0.5})
      for (const double height : {0.3, 0.2}) {
        CAPTURE(static_cast<int>(kind));
        CAPTURE(theta);
        CAPTURE(height);
        // Two balls on springs touch at once; without gravity the lower start touches where a step ends.
        Network net;
        const MaterialIndex soft = net.add_material(damped(20.0, 0.5));
        for (const double x : {0.0, 1.0}) {
          const NodeIndex ball = net.add_node(point({x, 0, height}, 1.0, {0.1, 0, -1.0}));
          const NodeIndex above = net.add_node(point({x, 0, height + 1.0}, 2.0, {0, 0, -1.0}));
          net.add_spring(ball, above, soft);
        }
        Plane floor;
        floor.friction = {kind, 0.0};
        floor.restitution = 0.5;
        net.add_plane(floor);
        const auto shared = std::make_shared<const Network>(net);
        MotionDerivatives motion(
            shared, plugins(), located(theta, 0.02), 0.5,
            {{Kind::spring_parameter, false, "stiffness", {0, 1}}, {Kind::mass, false, "", {0, 1, 2}}});
        const VectorXd values = motion.values_of_network();
        motion.run(values);
        const Loss loss(motion.step_count() + 1, net.nodes().size());
        const VectorXd gradient = loss.gradient(motion);
        const Eigen::MatrixXd changes = Eigen::MatrixXd::Identity(values.size(), values.size());
        const VectorXd along = loss.along(motion, changes);
        CHECK((gradient - along).norm() <= 1e-8 * along.norm());
        // Alike for both, whichever of them counts as the first.
        CHECK(motion.events().size() >= 2);
      }
}

TEST_CASE("the gradient does not lose accuracy where an event is just before the end of a step") {
  for (const double share : {1e-2, 1e-3, 1e-4, 1e-5})
    for (const double accuracy : {1e-7, 1e-10}) {
      CAPTURE(share);
      CAPTURE(accuracy);
      Network net;
      const NodeIndex ball = net.add_node(point({0, 0, 0.2 - 0.02 * share}, 1.0, {0, 0, -1.0}));
      net.add_spring(ball, net.add_node(point({0, 0, 1.5}, 2.0, {0, 0, -1.0})), net.add_material(damped(20.0, 0.5)));
      Plane floor;
      floor.friction = {Friction::Kind::none, 0.0};
      floor.restitution = 0.5;
      net.add_plane(floor);
      MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), located(0.5, 0.02), 0.5,
                               {{Kind::spring_parameter, false, "stiffness", {0}}, {Kind::mass, false, "", {0, 1}}});
      motion.set_accuracy(accuracy);
      motion.run(motion.values_of_network());
      const Loss loss(motion.step_count() + 1, 2);
      const VectorXd along = loss.along(motion, Eigen::MatrixXd::Identity(3, 3));
      CHECK((loss.gradient(motion) - along).norm() <= 10.0 * accuracy * along.norm());
    }
}

TEST_CASE("the gradient of a motion in which springs break has the motion of the ruptures in it") {
  const Network net = torn_within_step();
  CHECK(check_derivatives(net, located(1.0, 0.01), 0.26, of_torn(net), differences) > 6);
  for (const std::size_t memory : {std::size_t{1} << 30, std::size_t{90'000}}) {
    CAPTURE(memory);
    CHECK(check_derivatives(net, located(0.5, 0.01), 1.0, of_torn(net),
                            {differences.way, differences.accuracy, memory}) > 6);
  }
}

TEST_CASE("derivatives add up to the change of a motion whose events move from step to step") {
  const auto net = std::make_shared<const Network>(torn_within_step());
  std::size_t moved = 0;
  // How far the sum is from the change, as a share of it.
  const auto error_of = [&](const SimulationOptions& options) {
    MotionDerivatives motion(net, plugins(), options, 0.25, of_torn(*net));
    const VectorXd values = motion.values_of_network();
    motion.run(values);
    const Loss loss(motion.step_count() + 1, net->nodes().size());
    Dice dice(4);
    MatrixXd change(values.size(), 1);
    for (Eigen::Index i = 0; i < change.size(); ++i)
      change.data()[i] = dice.between(-1, 1) * std::max(0.1, std::abs(values[i]));
    constexpr double far = 0.004;
    constexpr int count = 40;
    std::vector<double> first;
    double sum = 0.0, size = 0.0;
    for (int i = 0; i < count; ++i) {
      motion.run(values + far * (i + 0.5) / count * change);
      std::vector<double> ends;  // of their steps
      for (const Event& each : motion.events())
        ends.push_back(std::ceil(each.time / options.time_step - 1e-6) * options.time_step);
      if (i == 0) first = ends;
      REQUIRE(ends.size() == first.size());
      for (std::size_t e = 0; e < ends.size(); ++e) moved += ends[e] != first[e] ? 1 : 0;
      const double own = loss.along(motion, change)[0] * far / count;
      sum += own;
      size += std::abs(own);
    }
    motion.run(values + far * change);
    const double end = loss.of(motion);
    motion.run(values);
    return std::abs(sum - (end - loss.of(motion))) / size;
  };
  CHECK(error_of(located(0.5, 0.01)) < 2e-3);
  CHECK(moved > 0);
  CHECK(error_of(method(0.5, newton, 0.01)) > 2e-2);
}

TEST_CASE("made step by step, derivatives have the motion of the events too") {
  const auto net = std::make_shared<const Network>(torn_within_step());
  const std::vector<LearnedValues> learned = of_torn(*net);
  MotionDerivatives whole(net, plugins(), located(0.5, 0.01), 0.6, learned);
  MotionDerivatives steps(net, plugins(), located(0.5, 0.01), 0.6, learned);
  const VectorXd values = whole.values_of_network();
  whole.run(values);
  REQUIRE(whole.events().size() > 3);
  const MatrixXd changes = MatrixXd::Ones(values.size(), 1);
  std::vector<MatrixXd> positions;
  whole.tangent(changes, [&](std::size_t, const MatrixXd& p, const MatrixXd&) { positions.push_back(p); });
  steps.begin_steps(values, changes);
  for (std::size_t k = 1; k <= whole.step_count(); ++k) {
    steps.make_step(values, changes);
    MatrixXd p, v;
    steps.step_tangents(1, p, v);
    CAPTURE(k);
    CHECK(p.isApprox(positions[k], 1e-7));
  }
}

TEST_CASE("events are located on surfaces that move and turn, with loads that change and nodes that are moved") {
  for (const Friction& friction : {held, smooth, rough})
    for (const double theta : {1.0, 0.5}) {
      CAPTURE(static_cast<int>(friction.kind));
      CAPTURE(theta);
      Network net = block_at({-0.1, -0.1, 0.6}, {0.1, 0.0, -1.0}, 6);
      Instrument ball;
      ball.name = "ball";
      ball.radius = 0.5;
      ball.friction = friction;
      ball.restitution = 0.3;
      ball.motion = Motion{};
      ball.motion->amplitude = {0.02, 0.01, 0.03};
      ball.motion->frequency = 1.5;
      ball.turn = Turn{};
      ball.turn->axis = {0.2, 1.0, 0.0};
      ball.turn->rate = 0.7;
      net.add_instrument(ball);
      Load pushed;
      pushed.nodes = {4, 6};
      pushed.force = {3.0, 1.0, 0.0};
      pushed.course.frequency = 2.0;
      net.add_load(pushed);
      Move move;
      move.nodes = {7};
      move.motion.amplitude = {0.02, 0.0, 0.05};
      move.motion.frequency = 2.0;
      net.add_move(move);
      std::vector<LearnedValues> learned = values_of(net);
      for (LearnedValues& each : learned)
        if (each.kind == Kind::mass || each.kind == Kind::initial_velocity) each.members = all(7);
      CHECK(check_derivatives(net, located(theta, 0.009), 0.198, learned, differences) > 10);
    }
}

// The rod's contacts go on through the parts of a step, in which no sweep decides about them.
TEST_CASE("a ball that bounces beside a rigid rod on the floor has the motion of its events in the derivatives") {
  for (const Friction& friction : {smooth, rough})
    for (const double theta : {1.0, 0.5}) {
      CAPTURE(static_cast<int>(friction.kind));
      CAPTURE(theta);
      Network net;
      net.add_rigid(net.add_node(point({0, 0, 0}, 1.0)), net.add_node(point({0.6, 0, 0}, 1.5)));
      const NodeIndex ball = net.add_node(point({0.1, 0.3, 0.15}, 0.7, {0.2, 0.1, -0.3}));
      const MaterialIndex soft = net.add_material(damped(20.0, 0.3));
      net.add_spring(0, ball, soft);
      net.add_spring(1, ball, soft);
      net.set_gravity({0, 0, -9.81});
      net.add_plane(floor_with(friction, Vector3::UnitZ(), 0.5));
      std::vector<LearnedValues> learned = values_of(net);
      learned.back().members = {ball};
      SimulationOptions options = located(theta, 0.01, wavefront);
      options.integrator.parameters["force_tolerance"] = 3e-10;
      CHECK(check_derivatives(net, options, 0.3, learned, differences) >= 2);
    }
}
