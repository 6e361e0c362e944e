// Changes during a run: loads in a time window, cuts, ruptures, contact with a plane.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

std::vector<Event> of_kind(const Simulation& simulation, Event::Kind kind) {
  std::vector<Event> result;
  for (const Event& event : simulation.events()) {
    if (event.kind == kind) result.push_back(event);
  }
  return result;
}

// Time t on the grid of step h, rounded up.
double grid_time(double t, double h) { return h * std::ceil(t / h - 1e-9); }

}  // namespace

TEST_CASE("the impulse of a force in a time window does not depend on where the steps are") {
  // The window begins and ends within steps, or lies within one.
  constexpr double mass = 0.4, h = 0.03;
  const Vector3 force(2.0, -1.0, 0.5);
  for (const std::pair<double, double>& window : {std::pair{0.1, 0.47}, {0.2, 0.205}, {0.0, 0.3}, {0.5, 2.0}}) {
    const double from = window.first, until = window.second;
    for (const Method& method : all_methods(1e-12)) {
      CAPTURE(from);
      CAPTURE(method.name);
      Network net;
      net.add_node(point(Vector3::Zero(), mass));
      net.add_load({{0}, force, from, until});
      Simulation simulation = simulate(net, method.integrator, h);
      constexpr double end = 1.0;
      simulation.advance_to(end);
      const double last = std::min(until, end);
      const Vector3 velocity = force / mass * (last - from);
      // Rounding of 34 steps; the reference is exact for a constant force, to its tolerance.
      const double bound = method.order == Order::reference ? 10 * reference_error(simulation) : 1e-13;
      CHECK((simulation.velocity(0) - velocity).norm() < bound);
      if (method.order != Order::reference) continue;
      const Vector3 position = velocity * (end - 0.5 * (last + from));
      CHECK((simulation.position(0) - position).norm() < bound);
    }
  }
}

TEST_CASE("a load that the program sets acts from then on") {
  constexpr double h = 0.05;
  for (const Method& method : all_methods(1e-12)) {
    CAPTURE(method.name);
    Network net;
    net.add_node(point(Vector3::Zero(), 2.0));
    Simulation simulation = simulate(net, method.integrator, h);
    simulation.advance_to(0.5);
    simulation.set_force(0, {0, 3, 0});
    simulation.advance_to(1.0);
    simulation.set_force(0, Vector3::Zero());
    simulation.advance_to(1.5);
    const double bound = method.order == Order::reference ? 10 * reference_error(simulation) : 1e-13;
    CHECK((simulation.velocity(0) - Vector3(0, 0.75, 0)).norm() < bound);
  }
}

TEST_CASE("a hanging weight falls from the time its spring is cut") {
  constexpr double gravity = 9.81, stiffness = 50.0, mass = 0.5, h = 0.01, end = 0.8;
  for (const double time : {0.4, 0.4049}) {
    for (const Method& method : all_methods(1e-11)) {
      CAPTURE(time);
      CAPTURE(method.name);
      Network net = oscillator(damped(stiffness, 0.0), mass, 0.0);
      Node weight = net.nodes()[1];
      const double rest = -(1.0 + mass * gravity / stiffness);
      weight.position = {0, 0, rest};  // at rest from the start
      net.set_node(1, weight);
      net.set_gravity({0, 0, -gravity});
      net.add_cut({time, {0}, {}});
      Simulation simulation = simulate(net, method.integrator, h);
      simulation.advance_to(0.4 - h);
      CHECK(simulation.alive(0));
      CHECK(std::abs(simulation.position(1)[2] - rest) < 1e-9);  // at rest but for tolerances
      simulation.advance_to(end);
      CHECK_FALSE(simulation.alive(0));
      const auto cuts = of_kind(simulation, Event::Kind::cut);
      REQUIRE(cuts.size() == 1);
      const bool reference = method.order == Order::reference;
      const double cut = reference ? time : grid_time(time, h);  // the first committed time at or after it
      CHECK(std::abs(cuts[0].time - cut) < 1e-12);
      const double fall = end - cut;
      const double expected = rest - 0.5 * gravity * fall * (fall + (reference ? 0.0 : h));
      // Scale of velocities is 3 m/s.
      CHECK(std::abs(simulation.position(1)[2] - expected) < (reference ? 10 * reference_error(simulation) : 1e-9));
      CHECK(simulation.tension(0) == 0.0);
      CHECK((simulation.reaction(0) - Vector3(0, 0, gravity)).norm() < 1e-12);  // node 0 has 1 kg, and no spring pulls
    }
  }
}

TEST_CASE("a polygon cuts the springs that cross it when its time has come") {
  // Two weights on strings; the polygon lies below the first spring's end at first, and the weight falls past it.
  constexpr double h = 0.01;
  for (const Method& method : all_methods(1e-10)) {
    CAPTURE(method.name);
    Network net;
    const MaterialIndex material = net.add_material(damped(20.0, 0.0));
    for (const double x : {0.0, 3.0}) {
      Node ceiling = point({x, 0, 0});
      ceiling.fixed = true;
      const NodeIndex top = net.add_node(ceiling);
      net.add_spring(top, net.add_node(point({x, 0, -1})), material);
    }
    net.set_gravity({0, 0, -10});
    // Each oscillates between 1 and 2 m with omega = sqrt(20): at 1.25 m at t = 0.23 s, at 2 m at 0.70 s.
    const std::vector<Vector3> square{{-0.5, -0.5, -1.5}, {0.5, -0.5, -1.5}, {0.5, 0.5, -1.5}, {-0.5, 0.5, -1.5}};
    net.add_cut({0.05, {}, square});
    net.add_cut({0.7, {}, square});
    Simulation simulation = simulate(net, method.integrator, h);
    simulation.advance_to(0.6);
    CHECK(simulation.alive(0));  // it was above the polygon when that came for the first time
    simulation.advance_to(0.75);
    CHECK_FALSE(simulation.alive(0));
    CHECK(simulation.alive(1));  // beside the polygon
    CHECK(simulation.live_spring_count() == 1);
  }
}

TEST_CASE("a pulled spring breaks when its tension reaches the strength") {
  // From rest under a constant force: x = (F / k) (1 - cos(omega t)), T = k x = S at t = acos(1 - S / F) / omega.
  constexpr double mass = 0.5, stiffness = 8.0, force = 1.0, strength = 1.4, h = 0.01, end = 1.2;
  const double omega = std::sqrt(stiffness / mass);
  const double rupture = std::acos(1.0 - strength / force) / omega;
  const double speed = force / stiffness * omega * std::sin(omega * rupture);
  for (const Method& method : all_methods(1e-11)) {
    CAPTURE(method.name);
    Network net =
        oscillator({LawUse{"rupturing", {{"stiffness", stiffness}, {"strength", strength}}}, std::nullopt}, mass, 0.0);
    net.add_load({{1}, {force, 0, 0}});
    Simulation simulation = simulate(net, method.integrator, h);
    simulation.advance_to(end);
    const auto ruptures = of_kind(simulation, Event::Kind::ruptured);
    REQUIRE(ruptures.size() == 1);
    CHECK(ruptures[0].index == 0);
    CHECK_FALSE(simulation.alive(0));
    const double left = end - rupture;
    const double expected = 1.0 + strength / stiffness + speed * left + 0.5 * force / mass * left * left;
    if (method.order == Order::reference) {
      // An error of the position shifts the time by that over the speed of 0.46 m/s.
      CHECK(std::abs(ruptures[0].time - rupture) < 3 * reference_error(simulation));
      CHECK(std::abs(simulation.position(1)[0] - expected) < 10 * reference_error(simulation));
      continue;
    }
    // The first committed state at or beyond the strength, of the discrete motion about F / k, which is known: see the
    // normal modes.
    double predicted = 0.0;
    for (int n = 1; predicted == 0.0; ++n) {
      double swing = std::pow(1 + h * h * omega * omega, -0.5 * n) * std::cos(n * std::atan(h * omega));
      if (method.order == Order::single_sweep) {
        const double angle = std::acos(1 - h * h * omega * omega / 2);
        swing =
            std::cos(n * angle) + (1 - h * h * omega * omega - std::cos(angle)) / std::sin(angle) * std::sin(n * angle);
      }
      if (force * (1 - swing) >= strength) predicted = n * h;
    }
    CHECK(ruptures[0].time == doctest::Approx(predicted).epsilon(1e-12));
    // Late by a step at most, and by the lag of a first-order method: the damping h omega^2 t / 2 of a tension of 1.4
    // N.
    CHECK(std::abs(ruptures[0].time - rupture) <
          h + 1.1 * h * omega * omega * rupture / 2 * force / (stiffness * speed));
  }
}

TEST_CASE("a rupturing spring does not break in compression unless asked") {
  constexpr double mass = 0.5, stiffness = 8.0, strength = 1.0;
  for (const double breaks : {0.0, 1.0}) {
    for (const Method& method : all_methods(1e-10)) {
      CAPTURE(breaks);
      CAPTURE(method.name);
      const LawUse law{"rupturing",
                       {{"stiffness", stiffness}, {"strength", strength}, {"breaks_in_compression", breaks}}};
      // Thrown towards the wall: compressed to 0.8 N / … more than the strength: v / omega = 0.2 m is 1.6 N.
      Simulation simulation = simulate(oscillator({law, std::nullopt}, mass, 0.0, -0.8), method.integrator, 0.005);
      simulation.advance_to(0.6);  // half a period is 0.79 s
      CHECK(simulation.alive(0) == (breaks == 0.0));
    }
  }
}

TEST_CASE("contact: dropped, held where it touched, released by a reverse force") {
  constexpr double gravity = 10.0, height = 0.2, mass = 0.5, h = 0.01;
  const double touch = std::sqrt(2 * height / gravity), speed = gravity * touch;
  constexpr double lift = 8.0, lift_from = 0.5, lift_until = 0.7;  // N against a weight of 5 N
  for (const Method& method : all_methods(1e-12)) {
    CAPTURE(method.name);
    const bool reference = method.order == Order::reference;
    Network net;
    net.add_node(point({0.3, 0, height}, mass, {0.5, 0, 0}));
    net.set_gravity({0, 0, -gravity});
    net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
    net.add_load({{0}, {0, 0, lift}, lift_from, lift_until});
    Simulation simulation = simulate(net, method.integrator, h);
    simulation.advance_to(0.4);
    const double tolerance = reference ? 10 * reference_error(simulation) : 1e-12;
    const auto touched = of_kind(simulation, Event::Kind::touched);
    REQUIRE(touched.size() == 1);
    // Both Euler methods fall g t (t + h) / 2; the touch is noted at the end of its step.
    double fall = touch;
    if (!reference) {
      fall = 0.0;
      while (0.5 * gravity * fall * (fall + h) <= height) fall += h;
      fall = grid_time(fall, h);
    }
    CHECK(std::abs(touched[0].time - fall) < tolerance);
    CHECK(std::abs(touched[0].time - touch) < (reference ? tolerance : h + 1e-12));
    // Held where it touched, at rest; the floor carries the weight.
    CHECK(simulation.held(0));
    CHECK(simulation.velocity(0) == Vector3::Zero());
    CHECK(std::abs(simulation.position(0)[2]) < tolerance);
    CHECK(std::abs(simulation.position(0)[0] - (0.3 + 0.5 * touch)) < (reference ? tolerance : 0.5 * h));
    CHECK((simulation.reaction(0) - Vector3(0, 0, mass * gravity)).norm() < 1e-12);
    // The impulse took all momentum; the velocity at the end of the step is at most g h beyond.
    const Vector3 impulse(-0.5 * mass, 0, mass * speed);
    CHECK((simulation.contact_impulse(0) - impulse).norm() < (reference ? 10 * tolerance : 1.01 * mass * gravity * h));

    // The lift begins: released, and up with (F - m g) / m = 6 m/s^2 from where it lay.
    const double x = simulation.position(0)[0];
    simulation.advance_to(lift_until);
    const auto released = of_kind(simulation, Event::Kind::released);
    REQUIRE(released.size() == 1);
    CHECK(std::abs(released[0].time - lift_from) < 1e-9);
    CHECK_FALSE(simulation.held(0));
    const double rise = lift_until - lift_from, up = lift / mass - gravity;
    const double expected = 0.5 * up * rise * (rise + (reference ? 0.0 : h));
    CHECK(std::abs(simulation.position(0)[2] - expected) < tolerance);
    CHECK(std::abs(simulation.velocity(0)[2] - up * rise) < tolerance);
    CHECK(std::abs(simulation.position(0)[0] - x) < tolerance);
    CHECK(simulation.reaction(0) == Vector3::Zero());

    // And down again, without a bounce.
    simulation.advance_to(1.5);
    CHECK(of_kind(simulation, Event::Kind::touched).size() == 2);
    CHECK(of_kind(simulation, Event::Kind::released).size() == 1);
    CHECK(simulation.held(0));
    CHECK(std::abs(simulation.position(0)[2]) < tolerance);
  }
}

TEST_CASE("contact: a tilted plane holds a node where it touched, the paper's infinite friction") {
  constexpr double h = 0.01, gravity = 10.0;
  const Vector3 normal = Vector3(1, 0, 2).normalized();
  for (const Method& method : all_methods(1e-12)) {
    CAPTURE(method.name);
    Network net;
    net.add_node(point({0, 0, 1.0}, 2.0));
    net.set_gravity({0, 0, -gravity});
    net.add_plane({"slope", Vector3(0, 0, 0.5), normal});
    Simulation simulation = simulate(net, method.integrator, h);
    simulation.advance_to(1.0);
    const double tolerance = method.order == Order::reference ? 10 * reference_error(simulation) : 1e-12;
    CHECK(simulation.held(0));
    CHECK((simulation.position(0) - Vector3(0, 0, 0.5)).norm() < tolerance);  // straight down, and it stays
    CHECK((simulation.reaction(0) - Vector3(0, 0, 20.0)).norm() < 1e-12);
  }
}

TEST_CASE("contact: a node that starts on the surface with a force into it is held from the start") {
  for (const Method& method : all_methods(1e-12)) {
    CAPTURE(method.name);
    Network net;
    net.add_node(point({0.1, 0.2, 0}));
    net.set_gravity({1, 0, -10});
    net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
    Simulation simulation = simulate(net, method.integrator, 0.05);
    CHECK(simulation.held(0));
    simulation.advance_to(1.0);
    CHECK(simulation.position(0) == Vector3(0.1, 0.2, 0));
    CHECK(simulation.reaction(0) == Vector3(-1, 0, 10));
  }
}
