// Quantities of all nodes and springs at once, and energies.

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// That falls, hangs by a node, and has lost a spring; numbered anew in memory.
Simulation cube_on_the_way() {
  Network net = cube(3.0, 2.0, 0.2, 0.02);
  net.fix(63);
  Simulation simulation = simulate(net, recurrent(newton, 1e-10), 0.05);
  simulation.cut({5});
  simulation.advance_to(2.0);
  return simulation;
}

}  // namespace

TEST_CASE("maps have what is asked one by one, and follow the state") {
  Simulation simulation = cube_on_the_way();
  for (int step = 0; step < 3; ++step) {
    const Eigen::Matrix3Xd reactions = simulation.in_user_order(simulation.reactions());
    const Eigen::Matrix3Xd positions = simulation.in_user_order(simulation.positions());
    for (NodeIndex k = 0; k < simulation.node_count(); ++k) {
      CHECK(Vector3(reactions.col(k)) == simulation.reaction(k));
      CHECK(Vector3(positions.col(k)) == simulation.position(k));
    }
    CHECK(reactions.norm() > 0.1);
    std::vector<double> tensions, energies;
    simulation.tensions(tensions);
    simulation.spring_energies(energies);
    const ConstValueMap tension_map = simulation.tensions(), energy_map = simulation.spring_energies();
    REQUIRE(static_cast<std::size_t>(tension_map.size()) == simulation.spring_count());
    for (SpringIndex s = 0; s < simulation.spring_count(); ++s) {
      CHECK(tension_map[s] == tensions[s]);
      CHECK(energy_map[s] == energies[s]);
      if (s % 17 == 0) CHECK(tension_map[s] == doctest::Approx(simulation.tension(s)).epsilon(1e-12));
    }
    CHECK(tension_map[5] == 0.0);
    // The same state: nothing is computed anew.
    CHECK(simulation.tensions().data() == tension_map.data());
    const double before = tension_map.sum();
    if (step == 0) simulation.step();
    if (step == 1) simulation.cut({6, 7, 8});
    CHECK((step == 2 || simulation.tensions().sum() != before));
  }
  CHECK(simulation.tensions()[6] == 0.0);
  simulation.set_position(0, simulation.position(0) + Vector3(0, 0, 0.1));
  CHECK(simulation.tensions()[0] == doctest::Approx(simulation.tension(0)).epsilon(1e-12));
}

TEST_CASE("a map of another network is refused") {
  const Simulation one = cube_on_the_way();
  const Simulation other = simulate(oscillator(damped(1.0, 0.0), 1.0, 0.1), cvode(1e-8), 0.1);
  CHECK_THROWS_AS(static_cast<void>(one.in_user_order(other.positions())), Error);
}

TEST_CASE("energies by kind, by hand") {
  Network net;
  net.add_node(point({0, 0, 1}, 2.0, {1, 0, 0}));
  net.add_node(point({0, 3, 1}, 4.0, {0, 0, 2}));
  net.add_node(point({4, 0, 1}, 1.0));
  const MaterialIndex material = net.add_material(damped(8.0, 1.0));
  net.add_spring(0, 1, material, 2.0);
  net.add_element(Invariant::area, {0, 2, 1}, material, 5.0);  // 6 m^2 now
  net.set_gravity({0, 0, -5});
  Simulation simulation = simulate(net, recurrent(newton, 1e-10), 0.1);
  const Energies energies = simulation.energies();
  CHECK(energies.kinetic == 0.5 * 2.0 * 1.0 + 0.5 * 4.0 * 4.0);
  CHECK(energies.springs == doctest::Approx(0.5 * 8.0 * 1.0).epsilon(1e-15));
  CHECK(energies.elements == doctest::Approx(0.5 * 8.0 * 1.0).epsilon(1e-14));
  CHECK(energies.gravity == doctest::Approx(5.0 * 7.0).epsilon(1e-15));
  CHECK(energies.total() ==
        doctest::Approx(simulation.kinetic_energy() + simulation.potential_energy()).epsilon(1e-15));
  CHECK(simulation.spring_energies()[0] == doctest::Approx(energies.springs).epsilon(1e-15));
}

TEST_CASE("springs and elements of a node are those that are left, in rising order") {
  Network net = cube(3.0, 2.0, 0.2, 0.5);
  const MaterialIndex material = net.add_material(damped(1.0, 0.0));
  net.add_element(Invariant::area, {0, 1, 4}, material);
  net.add_element(Invariant::angle, {0, 1, 2}, material);
  net.add_element(Invariant::volume, {1, 4, 16, 0}, material);
  Simulation simulation = simulate(net, recurrent(newton, 1e-10), 0.05);
  const auto expected = [&](NodeIndex node) {
    std::vector<SpringIndex> springs;
    for (SpringIndex s = 0; s < net.springs().size(); ++s)
      if (simulation.alive(s) && (net.springs()[s].first == node || net.springs()[s].second == node))
        springs.push_back(s);
    return springs;
  };
  for (NodeIndex k = 0; k < 64; ++k) CHECK(simulation.springs_of(k) == expected(k));
  CHECK(simulation.elements_of(0) == std::vector<ElementIndex>{0, 1, 2});
  CHECK(simulation.elements_of(2) == std::vector<ElementIndex>{1});
  CHECK(simulation.elements_of(63).empty());
  simulation.cut({expected(1)[0]});
  simulation.cut_polygon({{0.5, -1, -1}, {0.5, 4, -1}, {0.5, 4, 5}, {0.5, -1, 5}});
  for (NodeIndex k = 0; k < 64; ++k) CHECK(simulation.springs_of(k) == expected(k));
  CHECK(simulation.elements_of(0).empty());
  CHECK_THROWS_AS(static_cast<void>(simulation.springs_of(64)), Error);
  CHECK_THROWS_AS(static_cast<void>(simulation.elements_of(64)), Error);
}

TEST_CASE("limits of the time step are those at the present state, and asking leaves the run alone") {
  // An oscillator's critical step is 2 / omega for symplectic Euler and Verlet; a spring twice as stiff after a cut of
  // its partner, or a state on the stiff part of a nonlinear law, has another one.
  Network net;
  net.add_node({.fixed = true});
  net.add_node(point({1, 0, 0}, 1.0));
  net.add_spring(0, 1, net.add_material(damped(300.0, 0.0)));
  net.add_spring(0, 1, net.add_material(damped(100.0, 0.0)));
  Simulation simulation = simulate(net, LawUse{"verlet", {}}, 0.01);
  std::vector<TimeStepLimit> limits = simulation.time_step_limits();
  REQUIRE(limits.size() == 1);
  CHECK(limits[0].time_step == doctest::Approx(2.0 / std::sqrt(400.0)).epsilon(1e-6));
  REQUIRE(limits[0].node);
  CHECK(*limits[0].node == 1);
  simulation.cut({0});
  limits = simulation.time_step_limits();
  CHECK(limits[0].time_step == doctest::Approx(2.0 / std::sqrt(100.0)).epsilon(1e-6));
  for (const LawUse& integrator : {recurrent(newton, 1e-10), LawUse{"verlet", {}}, cvode(1e-8), generalized_alpha()}) {
    CAPTURE(integrator.id);
    Simulation asked = simulate(cube(3.0, 2.0, 0.2, 0.02), integrator, 0.05);
    Simulation silent = simulate(cube(3.0, 2.0, 0.2, 0.02), integrator, 0.05);
    for (int step = 0; step < 20; ++step) {
      static_cast<void>(asked.time_step_limits());
      asked.step();
      silent.step();
      CHECK(asked.positions() == silent.positions());
      CHECK(asked.velocities() == silent.velocities());
    }
  }
}
