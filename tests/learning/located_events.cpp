// Derivatives of motions whose steps are divided where events are located: the times of the events move, too.

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/learn.hpp>
#include <springnet/motion_derivatives.hpp>

#include "generator.hpp"
#include "learning_nets.hpp"
#include "motion_loss.hpp"
#include "nets.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

constexpr Friction held{Friction::Kind::held, 0.0}, smooth{Friction::Kind::none, 0.0},
    rough{Friction::Kind::coulomb, 0.3};

SimulationOptions located(double theta, double step, double rule = newton) {
  SimulationOptions result = method(theta, rule, step);
  result.integrator.parameters["events"] = 1.0;
  return result;
}

Plane floor_with(const Friction& friction, double restitution = 0.0, const Vector3& normal = Vector3::UnitZ()) {
  Plane plane;
  plane.name = "floor";
  plane.normal = normal;
  plane.friction = friction;
  plane.restitution = restitution;
  return plane;
}

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

// Of the position of a node at the end by all values.
VectorXd gradient_of_end(MotionDerivatives& motion, NodeIndex node, Eigen::Index axis) {
  return motion.adjoint([&](std::size_t state, MotionDerivatives::StateChange& add) {
    if (state == motion.step_count()) add.positions(axis, node) = 1.0;
  });
}

// Returns the number of events. The adjoint against the tangent, and both against differences, so near that no event
// moves to another step: there the derivative of the method has a kink of its order.
std::size_t check_derivatives(const Network& given, const SimulationOptions& options, double duration,
                              std::vector<LearnedValues> learned, double way = 3e-5, double accuracy = 1e-5,
                              std::size_t memory = std::size_t{1} << 30) {
  const auto net = std::make_shared<const Network>(given);
  MotionDerivatives motion(net, plugins(), options, duration, std::move(learned));
  motion.set_memory(memory);
  const VectorXd values = motion.values_of_network();
  motion.run(values);
  const auto steps_of = [&] {
    std::vector<long> result;
    for (const Event& each : motion.events()) result.push_back(std::lround(std::ceil(each.time / options.time_step)));
    return result;
  };
  const std::vector<long> steps = steps_of();
  const Loss loss(motion.step_count() + 1, net->nodes().size());
  const VectorXd gradient = loss.gradient(motion);
  Dice dice(3);
  MatrixXd changes(values.size(), 2);
  for (Eigen::Index i = 0; i < changes.size(); ++i)
    changes.data()[i] = dice.between(-1, 1) * std::max(0.1, std::abs(values[i % values.size()]));
  const VectorXd along = loss.along(motion, changes);
  CHECK((motion.kept().steps_again > 0) == (memory < std::size_t{1} << 30));
  for (Eigen::Index j = 0; j < changes.cols(); ++j) {
    CHECK(gradient.dot(changes.col(j)) == doctest::Approx(along[j]).epsilon(1e-8));
    const auto at = [&](double h) {
      motion.run(values + h * changes.col(j));
      const std::vector<long> now = steps_of();
      REQUIRE(now.size() == steps.size());
      for (std::size_t i = 0; i < now.size(); ++i) REQUIRE(now[i] == steps[i]);
      return loss.of(motion);
    };
    const double difference = (8.0 * (at(way) - at(-way)) - (at(2 * way) - at(-2 * way))) / (12.0 * way);
    CHECK(along[j] == doctest::Approx(difference).epsilon(accuracy));
  }
  return steps.size();
}

// Eight nodes as a block, no two alike.
Network block_at(const Vector3& place, const Vector3& velocity, std::uint64_t seed = 5) {
  Network net;
  Lattice lattice;
  lattice.nodes = {2, 2, 2};
  lattice.spacing = {0.2, 0.2, 0.2};
  lattice.origin = place;
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(200.0, 2.0)));
  Dice dice(seed);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.position += dice.in_box(0.02);
    own.velocity = velocity + dice.in_box(0.1);
    own.mass = dice.between(0.5, 2.0);
    net.set_node(k, own);
  }
  net.set_gravity({0, 0, -9.81});
  return net;
}

std::vector<LearnedValues> values_of(const Network& net) {
  const std::size_t springs = net.springs().size(), nodes = net.nodes().size();
  std::vector<std::uint32_t> moving = all(nodes);
  std::erase_if(moving, [&](std::uint32_t k) { return net.nodes()[k].fixed; });
  std::vector<LearnedValues> result;
  if (springs > 0)
    result = {{Kind::spring_parameter, false, "stiffness", all(springs)},
              {Kind::viscosity_parameter, false, "damping", all(springs)},
              {Kind::rest_length, false, "", all(springs)}};
  if (!net.loads().empty()) result.push_back({Kind::load, false, "", all(net.loads().size())});
  result.push_back({Kind::mass, false, "", moving});
  result.push_back({Kind::initial_velocity, false, "", moving});
  return result;
}

}  // namespace

// Theta 1/2 is exact where the acceleration is constant.
TEST_CASE(
    "the height of a ball after it has bounced depends on its mass, weight and velocity as the closed form says") {
  for (const double restitution : {0.4, 0.9}) {
    CAPTURE(restitution);
    constexpr double v0 = 0.7, end = 0.6;
    MotionDerivatives motion(std::make_shared<const Network>(falling({0.2, 0, v0}, floor_with(smooth, restitution))),
                             plugins(), located(0.5, 0.02), end, of_fall());
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
    MotionDerivatives motion(std::make_shared<const Network>(falling({0, 0, v0}, floor_with(smooth, restitution))),
                             plugins(), options, 0.6, of_fall());
    motion.run(motion.values_of_network());
    return gradient_of_end(motion, 0, 2)[4];
  };
  constexpr double d = 1e-6;
  CHECK(derivative(at_boundary - d, true) ==
        doctest::Approx(derivative(at_boundary + d, true)).epsilon(1e-4 * d / 1e-6));
  CHECK(std::abs(derivative(at_boundary - d, false) / derivative(at_boundary + d, false) - 1.0) > 1e-2);
}

TEST_CASE("the gradient of a body that falls on a plane has the motion of the events in it") {
  for (const Friction& friction : {held, smooth, rough})
    for (const double theta : {1.0, 0.5})
      for (const double restitution : {0.0, 0.5}) {
        CAPTURE(static_cast<int>(friction.kind));
        CAPTURE(theta);
        CAPTURE(restitution);
        Network net = block_at({0, 0, 0.1}, {0.4, 0.2, -0.5}, 6);
        net.add_plane(floor_with(friction, restitution, {0.2, -0.1, 1.0}));
        CHECK(check_derivatives(net, located(theta, 0.01), 0.22, values_of(net)) > 3);
      }
}

namespace {

// A block that is torn: weak springs, an angle and loaded faces along them, a cut.
Network torn() {
  Network net;
  Lattice lattice;
  lattice.nodes = {4, 2, 2};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, {},
                  net.add_material({LawUse{"rupturing", {{"stiffness", 60.0}, {"strength", 9.0}}},
                                    LawUse{"linear", {{"damping", 0.4}}}}));
  Dice dice(5);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.position += dice.in_box(0.04);
    own.velocity = Vector3(1.2 * own.position.x(), 0, 0) + dice.in_box(0.3);
    own.mass = dice.between(0.5, 2.0);
    net.set_node(k, own);
  }
  net.fix(0);
  const MaterialIndex bending =
      net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, LawUse{"linear", {{"damping", 0.2}}}});
  net.add_element(Invariant::angle, {1, 2, 7}, bending, 1.6);
  Load blown;
  blown.faces = net.faces();
  blown.pressure = 1.0;
  blown.follow = true;
  net.add_load(blown);
  net.add_cut({0.2037, {0, 5}, {}});
  return net;
}
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
  const Network net = torn();
  CHECK(check_derivatives(net, located(1.0, 0.01), 0.26, of_torn(net)) > 6);
  for (const std::size_t memory : {std::size_t{1} << 30, std::size_t{70'000}}) {
    CAPTURE(memory);
    CHECK(check_derivatives(net, located(0.5, 0.01), 1.0, of_torn(net), 3e-5, 1e-5, memory) > 6);
  }
}

TEST_CASE("derivatives add up to the change of a motion whose events move from step to step") {
  const auto net = std::make_shared<const Network>(torn());
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
  const auto net = std::make_shared<const Network>(torn());
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
      CHECK(check_derivatives(net, located(theta, 0.009), 0.198, learned) > 10);
    }
}

TEST_CASE("what has no derivative is refused with the event and what to do") {
  const auto message = [](const Network& net, const std::vector<LearnedValues>& learned, double duration) {
    MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), located(0.5, 0.01), duration, learned);
    std::string result;
    try {
      motion.run(motion.values_of_network());
      static_cast<void>(gradient_of_end(motion, 1, 0));
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::simulation);
      result = error.what();
    }
    return result;
  };
  // Laws that remember.
  Network remembering;
  Node wall = point({0, 0, 0}), node = point({1, 0, 0});
  wall.fixed = true;
  node.velocity = {2, 0, 0};
  remembering.add_node(wall);
  remembering.add_node(node);
  remembering.add_spring(0, 1,
                         remembering.add_material({LawUse{"damaging",
                                                          {{"stiffness", 40.0},
                                                           {"threshold_strain", 0.01},
                                                           {"softening_strain", 0.1},
                                                           {"relaxation_time", 0.05},
                                                           {"breaking_damage", 0.5}}},
                                                   std::nullopt}));
  const std::string states = message(remembering, {{Kind::mass, false, "", {1}}}, 0.6);
  CAPTURE(states);
  CHECK(states.find("the rupture of spring 0 at 0.") != std::string::npos);
  CHECK(states.find("laws that have internal states; set events = \"stepwise\"") != std::string::npos);
}

// A search that begins with a touch in other steps. Steps that are not divided have another motion, and no derivative
// of the time of the touch.
TEST_CASE("a search finds the values of a motion whose touch moves between steps") {
  constexpr double step = 0.02;
  Simulation motion(falling({0, 0, 0.7}, floor_with(smooth, 0.8)), plugins(), located(0.5, step));
  const Observations seen = observe(motion, 40, {0});
  const Network start = falling({0, 0, 0.4}, floor_with(smooth, 0.8), 1.15);
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
