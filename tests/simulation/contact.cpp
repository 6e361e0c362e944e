// Planes: a node is held where it touched until the force reverses, in all integrators.

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/scene.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

const LawUse touching_integrators[] = {recurrent(synchronous, 1e-12), recurrent(wavefront, 1e-12), single_sweep(),
                                       cvode(1e-10)};

Network ball(double height, double gravity) {
  Network net;
  net.add_node(point({0, 0, height}, 2.0));
  net.set_gravity({0, 0, -gravity});
  net.add_plane({"floor", {0, 0, 0}, {0, 0, 3}});
  return net;
}

}  // namespace

TEST_CASE("a falling node is held where it touches, and the floor bears its weight") {
  for (const LawUse& integrator : touching_integrators) {
    CAPTURE(integrator.id);
    Network net = ball(0.5, 10.0);
    Node node = net.nodes()[0];
    node.velocity = {1.0, 0.0, 0.0};
    net.set_node(0, node);
    Simulation simulation = simulate(net, integrator, 0.001);
    simulation.advance_to(1.0);
    // Falls 0.5 m in sqrt(2 h / g) = 0.3162 s, drifting at 1 m/s; the time step shifts the touch by at most two steps.
    CHECK(simulation.position(0)[0] == doctest::Approx(std::sqrt(0.1)).epsilon(0.007));
    CHECK(std::abs(simulation.position(0)[2]) <= 1e-12);
    CHECK(simulation.velocity(0) == Vector3::Zero());
    CHECK(simulation.held(0));
    CHECK(simulation.reaction(0)[2] == doctest::Approx(20.0).epsilon(1e-12));
    // m sqrt(2 g h) up; a step's worth of velocity either way.
    CHECK(simulation.contact_impulse(0)[2] == doctest::Approx(2.0 * std::sqrt(10.0)).epsilon(0.005));
    CHECK(simulation.contact_impulse(0)[0] == doctest::Approx(-2.0).epsilon(1e-9));
    REQUIRE(simulation.events().size() == 1);
    CHECK(simulation.events()[0].kind == Event::Kind::touched);
    CHECK(simulation.events()[0].time == doctest::Approx(std::sqrt(0.1)).epsilon(0.007));
  }
}

TEST_CASE("a node pressed into the floor is held from the start, released by a reverse force, and held again") {
  for (const LawUse& integrator : touching_integrators) {
    CAPTURE(integrator.id);
    Network net = ball(0.0, 10.0);
    net.add_load({{0}, {0, 0, 30.0}, 0.1, 0.3});  // net force 10 N up on 2 kg
    Simulation simulation = simulate(net, integrator, 0.001);
    CHECK(simulation.held(0));
    simulation.advance_to(0.1);
    CHECK(simulation.position(0)[2] == 0.0);
    simulation.advance_to(0.3);
    CHECK_FALSE(simulation.held(0));
    // 5 m/s^2 for 0.2 s: 0.1 m, and first order adds at most a v dt / 2 each step: 0.5 % of it.
    CHECK(simulation.position(0)[2] == doctest::Approx(0.1).epsilon(0.006));
    CHECK(simulation.velocity(0)[2] == doctest::Approx(1.0).epsilon(1e-6));
    simulation.advance_to(1.0);
    CHECK(simulation.held(0));
    CHECK(std::abs(simulation.position(0)[2]) <= 1e-12);
    std::vector<Event::Kind> kinds;
    for (const Event& event : simulation.events()) kinds.push_back(event.kind);
    CHECK(kinds == std::vector<Event::Kind>{Event::Kind::touched, Event::Kind::released, Event::Kind::touched});
  }
}

TEST_CASE("a rigid body that falls flat rebounds with the coefficient of restitution, under every rule") {
  for (const double update : {synchronous, wavefront, block, coloured, newton}) {
    CAPTURE(update);
    Network net;
    net.add_node(point({0, 0, 0.1}, 2.0, {0.3, 0, -2.0}));
    net.add_node(point({1, 0, 0.1}, 2.0, {0.3, 0, -2.0}));
    net.add_rigid(0, 1);
    Plane floor;
    floor.friction.kind = Friction::Kind::none;
    floor.restitution = 0.6;
    net.add_plane(floor);
    Simulation simulation = simulate(net, recurrent(update, 1e-12), 0.02);
    simulation.advance_to(0.1);
    for (const NodeIndex k : {0u, 1u}) CHECK((simulation.velocity(k) - Vector3(0.3, 0, 1.2)).norm() <= 1e-12);
  }
}

TEST_CASE("a node sticks to the wall that it meets, and does not slide into the corner") {
  for (const LawUse& integrator : touching_integrators) {
    Network net;
    net.add_node(point({0.2, 0, 1.0}, 1.0, {-1.0, 0, 0}));
    net.add_plane({"wall", {0, 0, 0}, {1, 0, 0}});
    net.add_plane({"floor", {0, 0, 0}, {0, 0, 1}});
    net.set_gravity({0, 0, -1});
    Simulation simulation = simulate(net, integrator, 0.01);
    simulation.advance_to(3.0);
    // It meets the wall after 0.2 s and sticks there: gravity does not pull it off.
    CHECK(simulation.held(0));
    CHECK(std::abs(simulation.position(0)[0]) <= 1e-12);
    CHECK(simulation.position(0)[2] == doctest::Approx(1.0 - 0.5 * 0.04).epsilon(0.002));
  }
}

TEST_CASE("a node behind a plane is refused with its number") {
  const Network net = ball(-0.25, 1.0);
  CHECK_THROWS_WITH_AS(simulate(net, cvode(1e-8), 0.1), doctest::Contains("node 0 starts 0.25 m behind plane 'floor'"),
                       Error);
}

TEST_CASE("a load that is switched on presses a resting node down, wherever steps and outputs lie") {
  // Two masses on a spring stand on the floor without weight; the upper one is pressed from 0.505 s on.
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({0, 0, 1}));
  net.add_spring(0, 1, net.add_material(damped(20.0, 3.0)));
  net.add_plane({"floor", {0, 0, 0}, {0, 0, 1}});
  net.add_load({{1}, {0, 0, -5.0}, 0.505});
  Simulation coarse = simulate(net, cvode(1e-10), 1.0), fine = simulate(net, cvode(1e-10), 0.01);
  coarse.advance_to(4.0);
  fine.advance_to(4.0);
  // The same internal steps, but for the rounding of output times.
  CHECK((coarse.position(1) - fine.position(1)).norm() <= 1e-9);
  for (const LawUse& integrator : touching_integrators) {
    CAPTURE(integrator.id);
    Simulation simulation = simulate(net, integrator, 0.005);
    simulation.advance_to(10.0);
    CHECK(simulation.held(0));
    CHECK(std::abs(simulation.position(0)[2]) <= 1e-10);
    CHECK(simulation.position(1)[2] ==
          doctest::Approx(0.75).epsilon(1e-5));  // 5 N on 20 N/m, settled for 14 decay times
    CHECK(simulation.reaction(0)[2] == doctest::Approx(5.0).epsilon(1e-4));
    // The node touches only because the load starts, at rest: no impulse. A single sweep uses the forces at the start
    // of its step, so that its impulses lag behind the reported reaction by one step.
    const double lag = integrator.parameters.contains("sweeps") ? 0.005 * 5.0 : 0.0;
    CHECK(simulation.contact_impulse(0).norm() <= lag + 1e-3);
  }
}

TEST_CASE("a load on a resting node makes it touch at the time of its start") {
  Network net = ball(0.0, 0.0);
  net.add_load({{0}, {0, 0, -1.0}, 1.05});
  for (const double step : {0.5, 0.1, 0.01}) {
    Simulation simulation = simulate(net, cvode(1e-10), step);
    simulation.advance_to(2.0);
    REQUIRE(simulation.events().size() == 1);
    CHECK(simulation.events()[0].time == 1.05);
    CHECK(simulation.contact_impulse(0).norm() == 0.0);
  }
}

TEST_CASE("pulled off one plane of a corner, a node does not sink into the other") {
  for (const LawUse& integrator : touching_integrators) {
    CAPTURE(integrator.id);
    Network net;
    net.add_node(point({0, 0, 0}));
    net.add_plane({"wall", {0, 0, 0}, {1, 0, 0}});
    net.add_plane({"floor", {0, 0, 0}, {0, 0, 1}});
    net.set_gravity({-1, 0, -2});
    net.add_load({{0}, {4.0, 0, 0}, 0.33});
    Simulation simulation = simulate(net, integrator, 0.2);
    CHECK(simulation.events().size() == 1);  // held by one plane, though it lies on two
    simulation.advance_to(2.0);
    CHECK(simulation.held(0));
    CHECK(std::abs(simulation.position(0)[2]) <= 1e-9);
  }
}

TEST_CASE("a velocity set by the program lifts a held node or has no effect; positions behind a plane are refused") {
  for (const LawUse& integrator : touching_integrators) {
    CAPTURE(integrator.id);
    Simulation simulation = simulate(ball(0.0, 10.0), integrator, 0.001);
    REQUIRE(simulation.held(0));
    simulation.set_velocity(0, {1, 0, -2});
    simulation.advance_to(0.1);
    CHECK(simulation.held(0));
    CHECK(simulation.position(0).norm() <= 1e-12);
    simulation.set_velocity(0, {0, 0, 2});
    CHECK_FALSE(simulation.held(0));
    simulation.advance_to(0.2);
    // v t - g t^2 / 2, first order adds g t dt / 2.
    CHECK(simulation.position(0)[2] == doctest::Approx(0.15).epsilon(0.005));
    CHECK_THROWS_WITH_AS(simulation.set_position(0, {0, 0, -1}), doctest::Contains("1 m behind plane 'floor'"), Error);
    simulation.set_position(0, {0, 0, 0});
    simulation.set_velocity(0, {0, 0, 0});
    simulation.advance_to(0.3);
    CHECK(simulation.held(0));
    CHECK(std::abs(simulation.position(0)[2]) <= 1e-12);
  }
}

TEST_CASE("chattering contacts do not keep a step from settling") {
  // A damped block is cut from another and falls. On the floor, dampers decide whether its nodes touch, and the touch
  // changes the damper forces.
  constexpr const char* text = R"(
    [simulation]
    duration = 0.9
    time_step = 0.001
    [gravity]
    acceleration = [0, 0, -9.81]
    [[body]]
    name = "upper"
    mesh = { lattice = [3, 3, 3], spacing = 0.1, origin = [0, 0, 1.0], diagonals = "all" }
    neuron = { type = "point_mass", mass = 0.01 }
    spring = { type = "linear", stiffness = 20.0 }
    viscosity = { type = "linear", damping = 0.05 }
    [[body]]
    name = "lower"
    mesh = { lattice = [3, 3, 2], spacing = 0.1, origin = [0, 0, 0.8], diagonals = "all" }
    neuron = { type = "dragged", mass = 0.01, drag = 0.001 }
    spring = { type = "linear", stiffness = 20.0 }
    viscosity = { type = "linear", damping = 0.05 }
    [[connect]]
    from = { body = "lower", box = { min = [-inf, -inf, 0.85] } }
    to = { body = "upper", box = { max = [inf, inf, 1.05] } }
    within = 0.11
    spring = { type = "rupturing", stiffness = 20.0, strength = 0.2 }
    viscosity = { type = "linear", damping = 0.1 }
    [[fix]]
    select = { body = "upper", box = { min = [-inf, -inf, 1.15] } }
    [[cut]]
    time = 0.5
    select = { body = "lower", springs = [0] }
    [[plane]]
    point = [0, 0, 0]
    normal = [0, 0, 1]
  )";
  for (const double update : {synchronous, wavefront}) {
    Scene scene = parse_scene(text, "block", *plugins());
    scene.options.integrator = {"recurrent", {{"update", update}}};
    Simulation simulation(scene.network, plugins(), scene.options);
    std::uint64_t slowest = 0;
    while (simulation.time() < scene.duration - 1e-9) {
      const StepReport& report = simulation.step();  // throws where it does not settle
      slowest = std::max(slowest, report.sweeps);
      REQUIRE(report.residual <= 1e-5);
    }
    CHECK(simulation.events().size() > 20);
    CHECK(slowest < 150);
  }
}

// The force that presses a node against a surface, here of a spring forty times stiffer than m / h^2, must not move the
// point of contact. A bar falls at a slant without rotating, so its lower end touches right below its start.
TEST_CASE("a stiff bar that lands at a slant is held where its path met the floor") {
  for (const double update : {block, coloured, newton}) {
    CAPTURE(update);
    Network net;
    net.add_node(point({0, 0, 0.02}, 0.01));
    net.add_node(point({0.05, 0, 0.07}, 0.01));
    net.add_spring(0, 1, net.add_material(damped(1e5, 1.0)));
    net.set_gravity({0, 0, -9.81});
    net.add_plane({"floor", {0, 0, 0}, {0, 0, 1}});
    const double h = 0.002;
    Simulation simulation = simulate(net, recurrent(update, 1e-6, {{"max_sweeps", 20000}}), h);
    while (!simulation.held(0)) {
      REQUIRE(simulation.time() < 0.07);  // sqrt(2 0.02 / g) is 0.0639 s
      simulation.step();
    }
    CHECK(simulation.position(0).norm() < 1e-6);  // error of the sweeps; the spring force once moved it by 1 cm
    // The other end falls on for at most a step, and moves sideways so that the bar keeps its length.
    const Vector3 other = simulation.position(1);
    CHECK(std::abs(other.z() - 0.05) < 2 * 0.63 * h);
    CHECK(other.norm() == doctest::Approx(0.05 * std::sqrt(2.0)).epsilon(1e-3));
  }
}
