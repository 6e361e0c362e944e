// The state that events tell, against closed forms, in every integrator.

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct Method {
  std::string name;
  LawUse integrator;
  bool locates;  // events within a step
};

std::vector<Method> methods() {
  return {{"recurrent", recurrent(newton, 1e-12), false},
          {"second order", recurrent(newton, 1e-12, {{"theta", 0.5}}), false},
          {"located", recurrent(newton, 1e-12, {{"theta", 0.5}, {"events", 1.0}}), true},
          {"wavefront", recurrent(wavefront, 1e-12), false},
          {"verlet", LawUse{"verlet", {}}, false},
          {"generalized_alpha", generalized_alpha(), true},
          {"cvode", cvode(1e-10, {{"position_tolerance", 1e-12}, {"velocity_tolerance", 1e-12}}), true}};
}

const Event* first_of(const Simulation& simulation, Event::Kind kind) {
  for (const Event& event : simulation.events())
    if (event.kind == kind) return &event;
  return nullptr;
}

}  // namespace

TEST_CASE("a ball falls on a plane: time, place, impact velocity and normal") {
  constexpr double g = 9.81, height = 0.5, step = 1e-3, along = 0.3;
  const double speed = std::sqrt(2.0 * g * height), time = speed / g;
  for (const Method& method : methods()) {
    CAPTURE(method.name);
    Network net;
    net.add_node(point({5, 0, 100}));  // another one, that the engine may number first
    net.add_node(point({0.2, 0, height}, 2.0, {along, 0, 0}));
    net.set_gravity({0, 0, -g});
    net.add_plane({.name = "floor", .friction = {Friction::Kind::none}});
    Simulation simulation = simulate(net, method.integrator, step);
    simulation.advance_to(0.5);
    const Event* event = first_of(simulation, Event::Kind::touched);
    REQUIRE(event != nullptr);
    CHECK(event->index == 1);
    CHECK(event->surface == 0);
    // Methods that find events at the ends of steps: to a step, and the speed that is gained in one.
    const double late = method.locates ? 1e-6 : 1.01 * step, fast = method.locates ? 1e-5 : 2.02 * g * step;
    CHECK(std::abs(event->time - time) <= late);
    CHECK(std::abs(event->position.z()) < 1e-9);
    CHECK(std::abs(event->position.x() - (0.2 + along * event->time)) < 1e-3 * along + 1e-9);
    CHECK(std::abs(event->velocity.z() + speed) <= fast);
    CHECK(event->velocity.x() == doctest::Approx(along).epsilon(1e-9));
    CHECK(event->normal == Vector3::UnitZ());
    CHECK(event->impulse.z() == doctest::Approx(2.0 * speed).epsilon(fast / speed + 0.02));
    CHECK(std::isnan(event->value));
    CHECK(std::isnan(event->force));
    // The event has stopped it since.
    CHECK(std::abs(simulation.velocity(1).z()) < 1e-9);
  }
}

TEST_CASE("a ball rebounds from a sphere: the normal points from the sphere to the ball") {
  for (const Method& method : methods()) {
    CAPTURE(method.name);
    Network net;
    net.add_node(point({1, 1, 3}, 1.0, {0, 0, -2}));
    net.add_instrument({.name = "ball",
                        .first = {0, 0, 0},
                        .second = {0, 0, 0},
                        .radius = 2.0,
                        .friction = {Friction::Kind::none},
                        .restitution = 1.0});
    Simulation simulation = simulate(net, method.integrator, 1e-3);
    simulation.advance_to(1.0);
    const Event* event = first_of(simulation, Event::Kind::touched);
    REQUIRE(event != nullptr);
    const Vector3 place(1, 1, std::sqrt(2.0));
    CHECK((event->position - place).norm() < 5e-3);
    CHECK((event->normal - place / 2.0).norm() < 3e-3);
    CHECK((event->velocity - Vector3(0, 0, -2)).norm() < 1e-9);
    CHECK(std::abs(event->time - (3.0 - std::sqrt(2.0)) / 2.0) < 2e-3);
  }
}

TEST_CASE("a spring pulled at constant speed breaks at its strength, with that length and tension") {
  constexpr double stiffness = 50.0, strength = 10.0, speed = 0.5, step = 1e-3;  // N/m, N, m/s, s
  const double length = 1.0 + strength / stiffness, time = (length - 1.0) / speed;
  for (const Method& method : methods()) {
    CAPTURE(method.name);
    Network net;
    net.add_node({.fixed = true});
    net.add_node(point({0, 1, 0}));
    net.add_spring(
        0, 1,
        net.add_material({LawUse{"rupturing", {{"stiffness", stiffness}, {"strength", strength}}}, std::nullopt}));
    Motion motion;
    motion.interpolation = Motion::Interpolation::linear;
    motion.times = {0, 10};
    motion.displacements = {{0, 0, 0}, {0, 10 * speed, 0}};
    net.add_move({{1}, motion});
    net.add_node(point({7, 7, 7}));  // something that is free
    Simulation simulation = simulate(net, method.integrator, step);
    simulation.advance_to(0.5);
    const Event* event = first_of(simulation, Event::Kind::ruptured);
    REQUIRE(event != nullptr);
    const double late = method.locates ? 1e-7 : 1.001 * step;
    CHECK(event->time >= time - 1e-9);
    CHECK(event->time <= time + late);
    CHECK(event->value == doctest::Approx(1.0 + speed * event->time).epsilon(1e-9));
    CHECK(std::abs(event->value - length) <= speed * late + 1e-9);
    CHECK(event->force == doctest::Approx(stiffness * (event->value - 1.0)).epsilon(1e-9));
    CHECK(std::abs(event->force - strength) <= stiffness * speed * late + 1e-6);
    CHECK((event->position - Vector3(0, 0.5 * event->value, 0)).norm() < 1e-9);
    CHECK((event->velocity - Vector3(0, 0.5 * speed, 0)).norm() < 1e-9);
    CHECK(event->normal.isZero(0.0));
    CHECK(simulation.tension(0) == 0.0);
  }
}

TEST_CASE("a cut tells what the spring and its elements had") {
  Network net;
  net.add_node({.fixed = true});
  net.add_node(point({3, 0, 0}, 1.0, {0, 0, 2}));
  net.add_node(point({0, 4, 0}, 1.0, {0, 0, 1}));
  const MaterialIndex material = net.add_material(damped(8.0, 0.0));
  net.add_spring(0, 1, material, 2.0);
  net.add_spring(1, 2, material);
  net.add_element(Invariant::area, {0, 1, 2}, material, 5.0);
  net.add_load({.nodes = {1}, .force = {0, 0, 0}});
  Simulation simulation = simulate(net, recurrent(newton, 1e-12), 0.01);
  simulation.cut({1, 0, 1});
  REQUIRE(simulation.events().size() == 3);
  const Event &second = simulation.events()[0], &first = simulation.events()[1], &element = simulation.events()[2];
  CHECK(second.index == 1);
  CHECK(second.value == 5.0);
  CHECK(second.force == 0.0);
  CHECK(second.position == Vector3(1.5, 2, 0));
  CHECK(second.velocity == Vector3(0, 0, 1.5));
  CHECK(first.index == 0);
  CHECK(first.value == 3.0);
  CHECK(first.force == 8.0);
  CHECK(first.velocity == Vector3(0, 0, 1));
  CHECK(element.element);
  CHECK(element.value == doctest::Approx(6.0).epsilon(1e-15));
  CHECK(element.force == doctest::Approx(8.0).epsilon(1e-14));
  CHECK((element.position - Vector3(1, 4.0 / 3.0, 0)).norm() < 1e-15);
  CHECK((element.velocity - Vector3(0, 0, 1)).norm() < 1e-15);
  // In a saved state too.
  Simulation other = simulate(net, recurrent(newton, 1e-12), 0.01);
  other.restore(simulation.save());
  REQUIRE(other.events().size() == 3);
  CHECK(other.events()[1].force == 8.0);
  CHECK(other.events()[1].value == 3.0);
  CHECK(other.events()[2].position == element.position);
  CHECK(other.events()[2].velocity == element.velocity);
}

TEST_CASE("a node that the program takes off a plane was at rest there") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.set_gravity({0, 0, -1});
  net.add_plane({.name = "floor"});
  for (const Method& method : methods()) {
    CAPTURE(method.name);
    Simulation simulation = simulate(net, method.integrator, 0.01);
    simulation.advance_to(0.1);
    simulation.set_velocity(0, {0, 0, 3});
    const Event* event = first_of(simulation, Event::Kind::released);
    REQUIRE(event != nullptr);
    CHECK(event->velocity.norm() < 1e-9);
    CHECK(event->normal == Vector3::UnitZ());
  }
}

// Its mean over a step is reached half of a step later.
TEST_CASE(
    "a load that grows lifts a node off a floor, and makes another one slip, at the time that it has the force for "
    "it") {
  constexpr double g = 9.81, mass = 0.5, force = 12.0, frequency = 1.5, mu = 0.3, step = 5e-3;
  const auto reached = [](double needed) { return std::asin(needed / force) / (2.0 * std::acos(-1.0) * frequency); };
  for (const Method& method : methods()) {
    CAPTURE(method.name);
    Network net;
    net.add_node(point({0, 0, 0}, mass));
    net.add_node(point({1, 0, 0}, mass));
    net.set_gravity({0, 0, -g});
    net.add_plane({.name = "floor", .friction = {Friction::Kind::coulomb, mu}});
    for (const NodeIndex k : {0, 1}) {
      Load load;
      load.nodes = {k};
      load.force = k == 0 ? Vector3(0, 0, force) : Vector3(force, 0, 0);
      load.course.frequency = frequency;
      net.add_load(load);
    }
    Simulation simulation = simulate(net, method.integrator, step);
    simulation.advance_to(0.1);
    const Event *const leaves = first_of(simulation, Event::Kind::released), *const slips = first_of(
                                                                                 simulation, Event::Kind::slipped);
    REQUIRE(leaves != nullptr);
    REQUIRE(slips != nullptr);
    CHECK(leaves->index == 0);
    CHECK(slips->index == 1);
    // To what the load is evaluated to beside a time, 1e-6 of a step, or to a step.
    const double late = method.locates ? 1e-5 * step : 1.51 * step;
    CHECK(std::abs(leaves->time - reached(mass * g)) <= late);
    CHECK(std::abs(slips->time - reached(mu * mass * g)) <= late);
  }
}
