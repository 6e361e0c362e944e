// What changes while cvode runs, against closed forms: loads, contact, rupture, cuts, the embedding program.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/events.hpp>

#include "scenes.hpp"

namespace {
using namespace cvode_test;

std::vector<double> times_of(const Simulation& simulation, Event::Kind kind) {
  std::vector<double> times;
  for (const Event& event : simulation.events())
    if (event.kind == kind) times.push_back(event.time);
  return times;
}

Network with_ground(const Vector3& gravity) {
  Network network;
  network.set_gravity(gravity);
  Plane plane;
  plane.name = "ground";
  network.add_plane(plane);
  return network;
}

TEST_CASE("a force that is switched off at an odd time leaves its impulse") {
  for (const Method method : {bdf, adams}) {
    Network network;
    network.add_node(node({0, 0, 0}, 2.0));
    Load load;
    load.nodes = {0};
    load.force = {3, 0, 0};
    load.from = 0.1234567;
    load.until = 0.7312345;
    network.add_load(load);
    Simulation simulation = simulate(network, options(1e-8, 0.5, method));
    simulation.advance_to(2.0);
    const double duration = load.until - load.from;
    // Velocities linear in time are exact in every order: rounding only.
    CHECK(simulation.momentum()[0] == doctest::Approx(3 * duration).epsilon(1e-12));
    const double way = 0.5 * 1.5 * duration * duration + 1.5 * duration * (2.0 - load.until);
    // The position is quadratic: exact but for the first steps of first order, which the tolerance bounds.
    CHECK(simulation.position(0)[0] == doctest::Approx(way).epsilon(1e-6));
    CHECK(simulation.statistics().at("restarts") == 2);
  }
}

TEST_CASE("a dropped mass touches at the closed form's time, is held, and is released when a force pulls it up") {
  const double g = 9.81, height = 0.7, lift_from = 1.2345;
  Network network = with_ground({0, 0, -g});
  network.add_node(node({1, 2, height}, 2.0, {0.5, 0, 0}));
  Load load;
  load.nodes = {0};
  load.force = {0, 0, 30};  // against 19.62 N of weight
  load.from = lift_from;
  network.add_load(load);
  Simulation simulation = simulate(network, options(1e-10, 0.1));
  simulation.advance_to(1.0);
  const auto touched = times_of(simulation, Event::Kind::touched);
  REQUIRE(touched.size() == 1);
  const double fall = std::sqrt(2 * height / g);
  CHECK(touched[0] == doctest::Approx(fall).epsilon(1e-8));  // 1e-10 a step, some ten steps
  CHECK(simulation.held(0));
  // The position is that of the touch, on the surface; what slid is held (the paper's rule is infinite friction).
  CHECK(std::abs(simulation.position(0)[2]) < 1e-15);
  CHECK(simulation.position(0)[0] == doctest::Approx(1 + 0.5 * fall).epsilon(1e-8));
  CHECK(simulation.velocity(0).norm() == 0.0);
  CHECK(simulation.contact_impulse(0)[2] == doctest::Approx(2.0 * g * fall).epsilon(1e-8));
  simulation.advance_to(2.0);
  const auto released = times_of(simulation, Event::Kind::released);
  REQUIRE(released.size() == 1);
  CHECK(released[0] == lift_from);  // the stop time itself
  const double a = (30 - 2 * g) / 2, t = 2.0 - lift_from;
  CHECK(simulation.velocity(0)[2] == doctest::Approx(a * t).epsilon(1e-10));
  CHECK(simulation.position(0)[2] == doctest::Approx(a * t * t / 2).epsilon(1e-8));
  CHECK(times_of(simulation, Event::Kind::touched).size() == 1);
}

TEST_CASE("a node on the ground is released when the spring above it pulls with its weight") {
  // Node 0 (m 1 kg) lies on the ground, node 1 (M 2 kg) above it on a spring (k 100 N/m, rest length 1 m). With node 0
  // held, node 1 swings about z = 1 - M g / k; compressed by c below that at the start. The spring lifts node 0 when
  // its tension k (z - 1) reaches m g: -M g / k - c cos(w t) = m g / k.
  const double g = 9.81, k = 100, m = 1, M = 2, c = 0.5;
  Network network = with_ground({0, 0, -g});
  network.add_node(node({0, 0, 0}, m));
  network.add_node(node({0, 0, 1 - M * g / k - c}, M));
  network.add_spring(0, 1, network.add_material(linear(k)), 1.0);
  Simulation simulation = simulate(network, options(1e-10, 0.05));
  CHECK(simulation.held(0));  // from the start
  const double w = std::sqrt(k / M);
  const double lift = std::acos(-(m + M) * g / (k * c)) / w;
  simulation.advance_to(lift + 0.1);
  const auto released = times_of(simulation, Event::Kind::released);
  REQUIRE(released.size() == 1);
  CHECK(released[0] == doctest::Approx(lift).epsilon(1e-8));  // 1e-10 a step, a hundred steps
  CHECK(!simulation.held(0));
  CHECK(simulation.position(0)[2] > 0.0);
  CHECK(times_of(simulation, Event::Kind::touched).size() == 1);  // that of the start
  // The centre of mass flies from there on.
  const double speed = c * w * std::sin(w * lift) * M / (m + M);
  const double fly = simulation.time() - lift;
  const double start = M * (1 - M * g / k - c * std::cos(w * lift)) / (m + M);
  const double centre = (m * simulation.position(0)[2] + M * simulation.position(1)[2]) / (m + M);
  CHECK(centre == doctest::Approx(start + speed * fly - g * fly * fly / 2).epsilon(1e-7));
}

TEST_CASE("a block comes to rest on the ground: contacts end, and the ground carries its weight") {
  Simulation simulation = simulate(falling_lattice(3, 500.0, 20.0), options(1e-7, 0.5));
  simulation.advance_to(30.0);
  double carried = 0.0;
  for (NodeIndex k = 0; k < 27; ++k) {
    carried += simulation.reaction(k)[2];
    CHECK(simulation.position(k)[2] >= -1e-9);  // nothing sinks in
  }
  CHECK(carried == doctest::Approx(27.0).epsilon(1e-4));  // what still swings after 30 s
  CHECK(simulation.events().size() < 200);
}

TEST_CASE("a spring ruptures at the closed form's time, and its node moves on freely") {
  // m 2 kg, k 50 N/m, strength 10 N: T = k v0 / w sin w t reaches it at w t = asin(10 w / (k v0)).
  const double mass = 2, k = 50, strength = 10, speed = 3;
  Material material;
  material.spring = LawUse{"rupturing", {{"stiffness", k}, {"strength", strength}}};
  Simulation simulation = simulate(oscillator(material, mass, 0.0, speed), options(1e-10, 0.25));
  simulation.advance_to(1.0);
  const double w = std::sqrt(k / mass);
  const double rupture = std::asin(strength * w / (k * speed)) / w;
  const auto ruptured = times_of(simulation, Event::Kind::ruptured);
  REQUIRE(ruptured.size() == 1);
  CHECK(ruptured[0] == doctest::Approx(rupture).epsilon(1e-8));  // 1e-10 a step, a hundred steps
  CHECK(!simulation.alive(0));
  const double after = speed * std::cos(w * rupture);
  CHECK(simulation.velocity(1)[0] == doctest::Approx(after).epsilon(1e-8));
  CHECK(simulation.position(1)[0] == doctest::Approx(1 + strength / k + after * (1 - rupture)).epsilon(1e-8));
  CHECK(simulation.force(1).norm() == 0.0);
}

TEST_CASE("two ruptures at one time are both carried out") {
  // Two equal springs side by side carry the same load.
  Material material;
  material.spring = LawUse{"rupturing", {{"stiffness", 25.0}, {"strength", 5.0}}};
  Network network = oscillator(material, 2.0, 0.0, 3.0);
  network.add_spring(0, 1, 0, 1.0);
  Simulation simulation = simulate(network, options(1e-9, 0.5));
  simulation.advance_to(1.0);
  const auto ruptured = times_of(simulation, Event::Kind::ruptured);
  REQUIRE(ruptured.size() == 2);
  CHECK(ruptured[0] == doctest::Approx(ruptured[1]).epsilon(1e-12));
}

TEST_CASE("a cut happens at its time, whatever the time step") {
  const double when = 0.4321;
  Network network = oscillator(linear(50), 2.0, 0.2);
  Cut cut;
  cut.time = when;
  cut.springs = {0};
  network.add_cut(cut);
  Simulation simulation = simulate(network, options(1e-10, 1.0));
  simulation.step();
  CHECK(times_of(simulation, Event::Kind::cut) == std::vector{when});
  const double w = 5;
  // 1e-10 of the velocity scale (2 m/s) a step, a hundred steps
  CHECK(simulation.velocity(1)[0] == doctest::Approx(-0.2 * w * std::sin(w * when)).epsilon(1e-7));
  CHECK(simulation.position(1)[0] ==
        doctest::Approx(1 + 0.2 * std::cos(w * when) - 0.2 * w * std::sin(w * when) * (1 - when)).epsilon(1e-7));
}

TEST_CASE("changes by the embedding program take effect in the next step") {
  Network network;
  network.add_node(node({0, 0, 0}, 2.0));
  Simulation simulation = simulate(network, options(1e-8, 0.25));
  simulation.set_force(0, {4, 0, 0});
  simulation.advance_to(1.0);
  CHECK(simulation.velocity(0)[0] == doctest::Approx(2.0).epsilon(1e-12));  // linear in time: rounding
  simulation.set_force(0, {0, 0, 0});
  simulation.advance_to(2.0);
  CHECK(simulation.velocity(0)[0] == doctest::Approx(2.0).epsilon(1e-12));
  simulation.set_velocity(0, {0, -1, 0});
  simulation.set_position(0, {7, 0, 0});
  simulation.advance_to(3.0);
  CHECK(simulation.position(0)[0] == doctest::Approx(7.0).epsilon(1e-12));
  CHECK(simulation.position(0)[1] == doctest::Approx(-1.0).epsilon(1e-12));
  simulation.set_gravity({0, 0, -2});
  simulation.advance_to(4.0);
  CHECK(simulation.velocity(0)[2] == doctest::Approx(-2.0).epsilon(1e-12));
  simulation.set_fixed(0, true);
  simulation.advance_to(5.0);
  CHECK(simulation.velocity(0).norm() == 0.0);
  CHECK(simulation.position(0)[1] == doctest::Approx(-2.0).epsilon(1e-12));
  CHECK(simulation.statistics().at("restarts") == 4);
}

TEST_CASE("a held node is released as soon as the embedding program pulls it up") {
  Network network = with_ground({0, 0, -1});
  network.add_node(node({0, 0, 0}));
  Simulation simulation = simulate(network, options(1e-8, 0.5));
  simulation.advance_to(1.0);
  CHECK(simulation.held(0));
  simulation.set_force(0, {0, 0, 3});
  simulation.advance_to(2.0);
  CHECK(times_of(simulation, Event::Kind::released) == std::vector{1.0});
  CHECK(simulation.velocity(0)[2] == doctest::Approx(2.0).epsilon(1e-12));  // linear in time: rounding
}

}  // namespace
