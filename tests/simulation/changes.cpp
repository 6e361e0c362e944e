// Changes by the embedding program while a simulation runs.

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {
const LawUse integrators[] = {recurrent(synchronous, 1e-12), recurrent(wavefront, 1e-12), single_sweep(), cvode(1e-10)};
}

TEST_CASE("a force set by the program acts from the next step until it is reset") {
  for (const LawUse& integrator : integrators) {
    Network net;
    net.add_node(point(Vector3::Zero(), 4.0));
    Simulation simulation = simulate(net, integrator, 0.01);
    simulation.advance_to(0.5);
    simulation.set_force(0, {2.0, 0.0, 0.0});
    simulation.advance_to(1.5);
    simulation.set_force(0, Vector3::Zero());
    simulation.advance_to(2.0);
    // F t / m; 1e-9: cvode's tolerance, and the sum of a hundred equal terms in the network.
    CHECK(simulation.velocity(0)[0] == doctest::Approx(0.5).epsilon(1e-9));
  }
}

TEST_CASE("cuts by number and by polygon release nodes") {
  for (const LawUse& integrator : integrators) {
    Network net = chain(4, Vector3::Zero(), {0, 0, -1}, damped(1000.0, 5.0));
    net.fix(0);
    net.set_gravity({0, 0, -10});
    Simulation simulation = simulate(net, integrator, 0.001);
    simulation.advance_to(0.1);
    CHECK(simulation.tension(2) > 0.0);
    CHECK(simulation.cut({2, 2}) == 1);
    CHECK(simulation.cut({2}) == 0);
    CHECK_FALSE(simulation.alive(2));
    CHECK(simulation.tension(2) == 0.0);
    const double height = simulation.position(3)[2], speed = simulation.velocity(3)[2];
    simulation.advance_to(0.3);
    // Free fall; the first-order methods are off by g t dt / 2 = 1e-3 m.
    CHECK(simulation.position(3)[2] == doctest::Approx(height + 0.2 * speed - 0.2).epsilon(1.1e-3));
    CHECK(simulation.force(3) == Vector3(0, 0, -10));
    const double x = simulation.position(1)[2] - 0.5;
    CHECK(simulation.cut_polygon({{-1, -1, x}, {1, -1, x}, {0, 2, x}}) == 1);  // between nodes 1 and 2
    CHECK_FALSE(simulation.alive(1));
    CHECK(simulation.live_spring_count() == 1);
    CHECK(simulation.events().size() == 2);
    CHECK_THROWS_AS(simulation.cut({7}), Error);
  }
}

TEST_CASE("a fixed node stays, its reaction is the spring force, and it moves again when released") {
  for (const LawUse& integrator : integrators) {
    Network net = oscillator(damped(10.0, 0.0), 1.0, 0.0, 1.0);
    Simulation simulation = simulate(net, integrator, 0.001);
    simulation.advance_to(0.2);
    simulation.set_fixed(1, true);
    const Vector3 place = simulation.position(1);
    simulation.advance_to(0.4);
    CHECK(simulation.position(1) == place);
    CHECK(simulation.velocity(1) == Vector3::Zero());
    CHECK(simulation.reaction(1)[0] == doctest::Approx(10.0 * (place[0] - 1.0)).epsilon(1e-12));
    simulation.set_fixed(1, false);
    simulation.advance_to(0.5);
    CHECK(simulation.position(1)[0] < place[0]);
  }
}

TEST_CASE("the next step starts from states set by the program") {
  for (const LawUse& integrator : integrators) {
    Network net;
    net.add_node(point(Vector3::Zero()));
    Simulation simulation = simulate(net, integrator, 0.1);
    simulation.step();
    simulation.set_position(0, {5, 0, 0});
    simulation.set_velocity(0, {0, 1, 0});
    simulation.advance_to(1.1);
    CHECK(simulation.position(0)[0] == doctest::Approx(5.0).epsilon(1e-12));
    CHECK(simulation.position(0)[1] == doctest::Approx(1.0).epsilon(1e-9));
  }
}

TEST_CASE("a load window that does not fall on the grid of steps has its exact impulse") {
  for (const LawUse& integrator : integrators) {
    Network net;
    net.add_node(point(Vector3::Zero(), 2.0));
    net.add_load({{0}, {3.0, 0, 0}, 0.123, 0.777});
    Simulation simulation = simulate(net, integrator, 0.05);
    simulation.advance_to(1.0);
    // The impulse is exact whatever the step; cvode stops where the load switches.
    CHECK(simulation.velocity(0)[0] == doctest::Approx(3.0 * (0.777 - 0.123) / 2.0).epsilon(1e-9));
  }
}

TEST_CASE("the potential energy is that of the present state after every kind of change") {
  Simulation simulation = simulate(oscillator(damped(8.0, 0.0), 2.0, 0.5), single_sweep(), 0.01);
  const auto stretch = [&] { return simulation.position(1)[0] - 1.0; };
  CHECK(simulation.potential_energy() == doctest::Approx(0.5 * 8.0 * 0.25));
  simulation.step();
  CHECK(stretch() < 0.5);
  CHECK(simulation.potential_energy() == doctest::Approx(0.5 * 8.0 * stretch() * stretch()));
  simulation.set_position(1, {1.25, 0, 0});
  CHECK(simulation.potential_energy() == doctest::Approx(0.5 * 8.0 * 0.0625));
  simulation.set_gravity({-10.0, 0, 0});
  CHECK(simulation.potential_energy() == doctest::Approx(0.5 * 8.0 * 0.0625 + 2.0 * 10.0 * 1.25));
  simulation.cut({0});
  CHECK(simulation.potential_energy() == doctest::Approx(2.0 * 10.0 * 1.25));
}

TEST_CASE("nodes and springs that do not exist, and numbers that are not finite, are refused") {
  Network net;
  net.add_node(point(Vector3::Zero()));
  Simulation simulation = simulate(net, cvode(1e-8), 0.1);
  const double nan = std::nan("");
  CHECK_THROWS_WITH_AS(static_cast<void>(simulation.position(1)), doctest::Contains("node 1 does not exist"), Error);
  CHECK_THROWS_AS(simulation.set_force(0, {nan, 0, 0}), Error);
  CHECK_THROWS_AS(simulation.set_position(0, {0, nan, 0}), Error);
  CHECK_THROWS_AS(simulation.set_velocity(0, {0, nan, 0}), Error);
  CHECK_THROWS_AS(simulation.set_gravity({0, nan, 0}), Error);
  CHECK_THROWS_AS(static_cast<void>(simulation.tension(0)), Error);
  CHECK_THROWS_AS(simulation.advance_to(-1.0), Error);
  CHECK_THROWS_AS(simulation.advance_to(nan), Error);
}

TEST_CASE("a spring that is overloaded from the start breaks at the start") {
  for (const LawUse& integrator : integrators) {
    Network net;
    net.add_node(point({0, 0, 0}));
    net.add_node(point({2, 0, 0}));
    const LawUse law{"rupturing", {{"stiffness", 10.0}, {"strength", 5.0}}};
    net.add_spring(0, 1, net.add_material({law, std::nullopt}), 1.0);  // 10 N
    Simulation simulation = simulate(net, integrator, 0.1);
    REQUIRE(simulation.events().size() == 1);
    CHECK(simulation.events()[0].kind == Event::Kind::ruptured);
    CHECK(simulation.events()[0].time == 0.0);
    simulation.step();
    CHECK(simulation.position(1) == Vector3(2, 0, 0));
  }
}
