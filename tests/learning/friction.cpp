// Coefficients of friction that are learned: derivatives by them, and searches.

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/motion_derivatives.hpp>

#include "derivative_check.hpp"
#include "learning_nets.hpp"
#include "refusal.hpp"
#include "touching_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

constexpr Friction very_rough{Friction::Kind::coulomb, 0.5};

Plane wall_with(const Friction& friction) {
  Plane wall = floor_with(friction, -Vector3::UnitX());
  wall.name = "wall";
  wall.point = {0.7, 0, 0};
  return wall;
}

// With those of the net's own values that have most to do with contact.
std::vector<LearnedValues> with_friction(const Network& net, std::vector<std::uint32_t> surfaces) {
  std::vector<LearnedValues> result = values_of(net);
  result.push_back({Kind::friction, false, "", std::move(surfaces)});
  return result;
}

SimulationOptions settled(double theta, double rule) { return method(theta, rule, 0.02); }

// A mass that slides on the floor.
Network sliding(double friction, double speed = 1.0) {
  Network net;
  net.add_node(point({0, 0, 0}, 2.0, {speed, 0, 0}));
  net.set_gravity({0, 0, -9.81});
  net.add_plane(floor_with({Friction::Kind::coulomb, friction}));
  return net;
}

// A soft block that is thrown along the floor.
Network thrown(double friction, double stiffness) {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 2, 2};
  lattice.spacing = {0.2, 0.2, 0.2};
  lattice.origin = {0, 0, 0.02};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(stiffness, 5.0)));
  make_uneven(net, 3, 0.01, 0.1, [](const Vector3&) { return Vector3(1.5, 0.3, 0.0); });
  net.set_gravity({0, 0, -9.81});
  net.add_plane(floor_with({Friction::Kind::coulomb, friction}));
  return net;
}

}  // namespace

TEST_CASE("derivatives by friction are those of differences, of a body that falls between two surfaces") {
  for (const double theta : {1.0, 0.5})
    for (const double rule : {newton, wavefront}) {
      CAPTURE(theta);
      CAPTURE(rule);
      Network net = block_at({0, 0, 0.1}, {0.4, 0.2, -0.5}, 6);
      net.add_plane(floor_with(rough, {0.2, -0.1, 1.0}));
      net.add_plane(wall_with(very_rough));
      testing::check_derivatives(net, settled(theta, rule), 0.5, with_friction(net, {0, 1}));
    }
}

TEST_CASE("derivatives by friction of a node that slides along the edge of two surfaces") {
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    Network net;
    net.add_node(point({0.0, 0.05, 0.05}, 1.0, {0.5, -1.0, -1.0}));
    net.add_node(point({0.3, 0.4, 0.4}, 2.0));
    net.add_spring(0, 1, net.add_material(damped(20.0, 1.0)));
    net.set_gravity({0, -6, -7});
    net.add_plane(floor_with({Friction::Kind::coulomb, 0.1}));
    Plane wall = floor_with({Friction::Kind::coulomb, 0.15}, {0, 1, 0.2});
    wall.name = "wall";
    net.add_plane(wall);
    testing::check_derivatives(net, method(theta, newton, 0.01), 0.2, with_friction(net, {0, 1}));
  }
}

TEST_CASE("derivatives by the friction of an instrument that moves, and of a plane that had none to begin with") {
  Network net = block_at({0, 0, 0.1}, {0.4, 0.2, -0.5}, 6);
  net.add_plane(floor_with({Friction::Kind::coulomb, 0.0}, {0.2, -0.1, 1.0}));
  Instrument ball;
  ball.name = "ball";
  ball.first = ball.second = {0.1, 0.1, 0.45};
  ball.radius = 0.1;
  ball.friction = very_rough;
  Motion down;
  down.times = {0.0, 0.5};
  down.displacements = {Vector3::Zero(), Vector3(0.05, 0.0, -0.2)};
  ball.motion = down;
  net.add_instrument(ball);
  CHECK(select_learnable(net, *plugins(), "friction@ball").values.members == std::vector<std::uint32_t>{1});
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    testing::check_derivatives(net, settled(theta, newton), 0.4,
                               {{Kind::friction, false, "", {1}}, {Kind::mass, false, "", {0, 3, 6}}});
    // At 0 the coefficient cannot go down: one side of the derivative is there.
    MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), settled(theta, newton), 0.4,
                             {{Kind::friction, false, "", {0}}});
    const Eigen::VectorXd values = motion.values_of_network();
    motion.run(values);
    const Loss loss(motion.step_count() + 1, net.nodes().size());
    const double slope = loss.gradient(motion)[0];
    const auto at = [&](double mu) {
      motion.run(Eigen::VectorXd::Constant(1, mu));
      return loss.of(motion);
    };
    constexpr double h = 1e-6;
    CHECK(slope == doctest::Approx((-3.0 * at(0.0) + 4.0 * at(h) - at(2.0 * h)) / (2.0 * h)).epsilon(1e-5));
  }
}

TEST_CASE("derivatives by friction have the motion of located events") {
  for (const double theta : {1.0, 0.5})
    for (const double restitution : {0.0, 0.5}) {
      CAPTURE(theta);
      CAPTURE(restitution);
      Network net = block_at({0, 0, 0.1}, {0.4, 0.2, -0.5}, 6);
      net.add_plane(floor_with(rough, {0.2, -0.1, 1.0}, restitution));
      CHECK(testing::check_derivatives(net, located(theta, 0.01), 0.22, with_friction(net, {0}), {3e-5, 1e-5}) > 3);
    }
}

TEST_CASE("how far a mass slides depends on friction as the closed form says") {
  // x = v^2 / (2 mu g), from where it rests; until then v - mu g t.
  constexpr double mu = 0.3, speed = 1.0, g = 9.81;
  MotionDerivatives motion(std::make_shared<const Network>(sliding(mu, speed)), plugins(), located(0.5, 0.01), 0.5,
                           {{Kind::friction, false, "", {0}}});
  motion.run(motion.values_of_network());
  CHECK(motion.values_of_network()[0] == mu);
  const std::size_t last = motion.step_count();
  const auto gradient = [&](std::size_t state, bool of_velocity) {
    return motion.adjoint([&](std::size_t k, MotionDerivatives::StateChange& add) {
      if (k == state) (of_velocity ? add.velocities : add.positions)(0, 0) = 1.0;
    })[0];
  };
  // The trapezoidal rule is exact for constant forces.
  CHECK(motion.positions(last)(0, 0) == doctest::Approx(speed * speed / (2.0 * mu * g)).epsilon(1e-9));
  CHECK(gradient(last, false) == doctest::Approx(-speed * speed / (2.0 * mu * mu * g)).epsilon(1e-8));
  CHECK(std::abs(gradient(last, true)) < 1e-9);
  CHECK(gradient(20, true) == doctest::Approx(-g * motion.time(20)).epsilon(1e-9));
  CHECK(gradient(20, false) == doctest::Approx(-0.5 * g * motion.time(20) * motion.time(20)).epsilon(1e-8));
}

TEST_CASE(
    "nodes that stop at the same time have the closed form's derivatives, whatever rounding leaves of their slip") {
  constexpr double mu = 0.3, speed = 2.0, g = 9.81;
  for (const Vector3& between : {Vector3(0.1, 0, 0), Vector3(0, 0.1, 0)}) {
    Network net;
    net.add_node(point({0, 0, 0}, 0.1, {speed, 0, 0}));
    net.add_node(point(between, 0.1, {speed, 0, 0}));
    net.add_spring(0, 1, net.add_material(damped(200.0, 0.0)));
    net.set_gravity({0, 0, -g});
    net.add_plane(floor_with({Friction::Kind::coulomb, mu}));
    MotionDerivatives motion(std::make_shared<const Network>(net), plugins(), located(0.5, 0.01), 1.0,
                             {{Kind::friction, false, "", {0}}});
    motion.run(motion.values_of_network());
    for (Eigen::Index node = 0; node < 2; ++node) {
      CAPTURE(node);
      const double gradient = motion.adjoint([&](std::size_t k, MotionDerivatives::StateChange& add) {
        if (k == motion.step_count()) add.positions(0, node) = 1.0;
      })[0];
      CHECK(gradient == doctest::Approx(-speed * speed / (2.0 * mu * mu * g)).epsilon(1e-6));
    }
  }
}

TEST_CASE("friction is recovered from motion, with stiffness, and from the reference") {
  const SimulationOptions options = to_learn_with(0.5, 0.005);
  const Network real = thrown(0.35, 800.0), guess = thrown(0.2, 500.0);
  const auto learned_from = [&](Simulation& simulation) {
    return learn({experiment(guess, options, observe(simulation, 60, from_to(0, guess.nodes().size())))}, plugins(),
                 {select_learnable(guess, *plugins(), "friction"),
                  select_learnable(guess, *plugins(), "spring.stiffness:together")});
  };
  Simulation own(real, plugins(), options);
  const LearnedNet learned = learned_from(own);
  CAPTURE(learned.reason);
  REQUIRE(learned.parameters.size() > 1);
  const LearnedParameter& friction = learned.parameters[0];
  CHECK(friction.kind == Kind::friction);
  CHECK(name_of(friction) == "friction");
  CHECK(friction.start == 0.2);
  CHECK(friction.value == doctest::Approx(0.35).epsilon(1e-6));
  CHECK(learned.parameters[1].value == doctest::Approx(800.0).epsilon(1e-6));
  CHECK(to_json(learned).find("\"kind\": \"friction\",\n      \"surface\": 0") != std::string::npos);
  const std::vector<Learnable> all{select_learnable(guess, *plugins(), "friction"),
                                   select_learnable(guess, *plugins(), "spring.stiffness:together")};
  const Network written = with_values(std::make_shared<const Network>(guess), plugins(), all, learned.values);
  CHECK(written.planes()[0].friction.coefficient == friction.value);

  // Events are within its steps, so that it is off by some of their length.
  SimulationOptions reference = options;
  reference.integrator = cvode(1e-8);
  Simulation exact(real, plugins(), reference);
  CHECK(learned_from(exact).parameters[0].value == doctest::Approx(0.35).epsilon(0.02));
}

TEST_CASE("friction that is not there, or another one in each experiment, is refused") {
  Network net = sliding(0.3);
  Plane smooth_wall = wall_with(smooth);
  net.add_plane(smooth_wall);
  const auto refused = [&](const Network& of, const char* text) {
    return refusal_of([&] { static_cast<void>(select_learnable(of, *plugins(), text)); });
  };
  CHECK(select_learnable(net, *plugins(), "friction").values.members == std::vector<std::uint32_t>{0});
  CHECK(select_learnable(net, *plugins(), "friction@floor").values.members == std::vector<std::uint32_t>{0});
  CHECK(refused(net, "friction@wall")
            .find("of 'wall': give it a first guess, friction = 0.3; those with one are: floor") != std::string::npos);
  CHECK(refused(net, "friction@roof").find("no plane or instrument 'roof'") != std::string::npos);
  CHECK(refused(block_at({0, 0, 1}, {0, 0, 0}), "friction").find("friction = 0.3") != std::string::npos);
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  const Network other = sliding(0.4);
  Simulation first(net, plugins(), options), second(other, plugins(), options);
  const std::vector<Experiment> both{experiment(net, options, observe(first, 5, {0})),
                                     experiment(other, options, observe(second, 5, {0}))};
  CHECK(refusal_of([&] {
          static_cast<void>(learn(both, plugins(), {select_learnable(net, *plugins(), "friction")}));
        }).find("surface 0, 'floor', is learned for all experiments") != std::string::npos);
  const Network slippery = sliding(0.0);
  Simulation on_ice(slippery, plugins(), options);
  CHECK(refusal_of([&] {
          static_cast<void>(learn({experiment(slippery, options, observe(on_ice, 5, {0}))}, plugins(),
                                  {select_learnable(slippery, *plugins(), "friction")}));
        }).find("the friction of surface 0 starts at 0") != std::string::npos);
  CHECK(refusal_of([&] {
          MotionDerivatives(std::make_shared<const Network>(net), plugins(), options, 0.1,
                            {{Kind::friction, false, "", {1}}});
        }).find("surface 1 has no coefficient of friction to learn") != std::string::npos);
  Network rigid;
  rigid.add_node(point({0, 0, 0.001}, 1.0, {1, 0, 0}));
  rigid.add_node(point({0.3, 0, 0.001}, 1.0, {1, 0, 0}));
  rigid.add_rigid(0, 1);
  rigid.set_gravity({0, 0, -9.81});
  rigid.add_plane(floor_with(rough));
  rigid.add_plane(wall_with(very_rough));
  MotionDerivatives motion(std::make_shared<const Network>(rigid), plugins(), options, 0.2,
                           {{Kind::friction, false, "", {0}}});
  motion.run(motion.values_of_network());
  std::string said;
  try {
    static_cast<void>(
        motion.adjoint([](std::size_t, MotionDerivatives::StateChange& add) { add.positions(0, 0) = 1.0; }));
  } catch (const Error& error) {
    said = error.what();
  }
  CHECK(said.find("is rigidly connected, touches plane 'floor'") != std::string::npos);
  // That of the wall, which it does not reach, is without effect.
  MotionDerivatives without(std::make_shared<const Network>(rigid), plugins(), options, 0.1,
                            {{Kind::friction, false, "", {1}}});
  without.run(without.values_of_network());
  CHECK(without.adjoint([](std::size_t, MotionDerivatives::StateChange& add) { add.positions(0, 0) = 1.0; })[0] == 0.0);
}

TEST_CASE("the friction of a surface is set while a simulation runs, saved and written") {
  const SimulationOptions options = to_learn_with(0.5, 0.01);
  Simulation simulation(sliding(0.1), plugins(), options);
  for (int i = 0; i < 10; ++i) simulation.step();
  const double before = simulation.velocity(0).x();
  simulation.set_friction(0, 0.4);
  CHECK(simulation.surface_friction(0).coefficient == 0.4);
  const std::string saved = simulation.save();
  simulation.step();
  CHECK(simulation.velocity(0).x() == doctest::Approx(before - 0.4 * 9.81 * 0.01).epsilon(1e-12));
  Simulation other(sliding(0.1), plugins(), options);
  other.restore(saved);
  CHECK(other.surface_friction(0).coefficient == 0.4);
  other.step();
  CHECK(other.velocity(0) == simulation.velocity(0));
  CHECK(other.present_network().planes()[0].friction.coefficient == 0.4);
  CHECK(refusal_of([&] { simulation.set_friction(1, 0.4); }).find("surface 1 does not exist") != std::string::npos);
  CHECK(refusal_of([&] { simulation.set_friction(0, -0.1); }).find("plane 'floor' (number 0) is -0.1") !=
        std::string::npos);
  Network slippery;
  slippery.add_node(point({0, 0, 1}));
  slippery.add_plane(floor_with(smooth));
  Simulation on_ice(slippery, plugins(), options);
  CHECK(refusal_of([&] { on_ice.set_friction(0, 0.1); }).find("has no coefficient of friction") != std::string::npos);
}
