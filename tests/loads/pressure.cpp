// Motion under following pressures: equilibria, update rules, Newton's method, threads.
#include <cmath>

#include <doctest/doctest.h>

#include "../random_nets/plain.hpp"
#include "loaded.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

PlainState state_of(const Simulation& simulation) {
  PlainState state;
  for (NodeIndex k = 0; k < simulation.node_count(); ++k) {
    state.position.push_back(simulation.position(k));
    state.velocity.push_back(simulation.velocity(k));
  }
  return state;
}

// An open shell, fixed at some nodes, that a pressure inflates.
Network sail(int levels, double pressure, double mass = 1e-2) {
  const TriangleMesh mesh = icosphere(levels, 1.0);
  std::vector<Face> faces = faces_of(mesh);
  faces.resize(faces.size() / 2);
  Network net = skin(mesh, mass, 20.0, 0.05);
  for (NodeIndex k = 0; k < mesh.points.size(); k += 5) net.fix(k);
  net.add_load(pressed(faces, pressure, true));
  return net;
}

}  // namespace

TEST_CASE("an octahedron under pressure comes to rest where springs and pressure balance") {
  constexpr double stiffness = 50.0, pressure = 8.0;
  const TriangleMesh mesh{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                          {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5}};
  Network net = skin(mesh, 0.1, stiffness, 1.0);
  net.add_load(pressed(faces_of(mesh), -pressure, true));
  Simulation simulation = simulate(net, recurrent(newton, 1e-12), 0.2);
  for (int i = 0; i < 100; ++i) simulation.step();
  // Each node: four springs of tension k (sqrt(2) r - l) at 45 degrees against p times a third of the areas of four
  // faces along the axis: 2 sqrt(2) k (sqrt(2) r - l) = 2/3 p r^2.
  const double a = 2.0 / 3.0 * pressure, b = -4.0 * stiffness, c = 2.0 * std::sqrt(2.0) * stiffness * std::sqrt(2.0);
  const double r = (-b - std::sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
  CHECK(r > 1.02);
  for (NodeIndex k = 0; k < 6; ++k) CHECK(simulation.position(k).norm() == doctest::Approx(r).epsilon(1e-9));
}

TEST_CASE("springs of an inflated sphere carry three times the pressure times the volume") {
  const TriangleMesh mesh = icosphere(2, 1.0);
  constexpr double pressure = 5.0;
  Network net = skin(mesh, 1e-2, 20.0, 0.1);
  net.add_load(pressed(faces_of(mesh), -pressure, true));
  Simulation simulation = simulate(net, recurrent(newton, 1e-10), 0.5);
  for (int i = 0; i < 60; ++i) CHECK(simulation.step().outcome == Outcome::settled);
  // The virial of a free body at rest: sum of T l = 3 p V, whatever its shape.
  double virial = 0.0;
  Network at_rest;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) at_rest.add_node(point(simulation.position(k)));
  for (SpringIndex s = 0; s < net.springs().size(); ++s) {
    const Spring& spring = net.springs()[s];
    virial += simulation.tension(s) * (simulation.position(spring.first) - simulation.position(spring.second)).norm();
  }
  const double volume = at_rest.value_of({Invariant::enclosed_volume, mesh.triangles, 0, 0.0});
  CHECK(volume > 1.05 * net.value_of({Invariant::enclosed_volume, mesh.triangles, 0, 0.0}));
  CHECK(virial == doctest::Approx(3.0 * pressure * volume).epsilon(1e-8));
}

TEST_CASE("every update rule settles at the step's equation, on an open surface too") {
  for (const bool open : {false, true}) {
    const TriangleMesh mesh = crumpled(1, 5);
    std::vector<Face> faces = faces_of(mesh);
    if (open) faces.resize(37);
    Network net = skin(mesh, 1.0, 10.0, 0.2), bare = net;
    net.add_load(pressed(faces, -3.0, true));
    constexpr double step = 0.05, tolerance = 1e-10;
    for (const double rule : {synchronous, wavefront, block, coloured, newton, automatic}) {
      CAPTURE(rule);
      Simulation simulation = simulate(net, recurrent(rule, tolerance), step);
      for (int i = 0; i < 3; ++i) {
        const PlainState before = state_of(simulation);
        REQUIRE(simulation.step().outcome == Outcome::settled);
        const PlainState after = state_of(simulation);
        std::vector<Vector3> forces =
            plain_forces(bare, after, std::vector<bool>(net.springs().size(), true), std::vector<bool>());
        const std::vector<Vector3> push = plain_pressure(faces, after.position, -3.0);
        for (std::size_t k = 0; k < forces.size(); ++k)
          CHECK(((after.velocity[k] - before.velocity[k]) / step - forces[k] - push[k]).norm() < 100.0 * tolerance);
      }
    }
  }
}

TEST_CASE("Newton's method converges quadratically under a following pressure") {
  Simulation simulation = simulate(sail(2, -8.0), recurrent(newton, 1e-10), 0.02);
  for (int i = 0; i < 20; ++i) {
    REQUIRE(simulation.step().outcome == Outcome::settled);
    // From forces of 1 N to 1e-10 N, with linear systems solved to 1e-3 at best: without a derivative each sweep would
    // gain a digit or two less.
    CHECK(simulation.last_report().sweeps <= 10);
  }
}

TEST_CASE("a sail moves alike in CVODE with and without its Jacobian, and the network approaches it") {
  const Network net = sail(1, -8.0);
  constexpr double until = 0.2;
  Simulation reference = simulate(net, cvode(1e-10, {{"method", 1}}), until);
  reference.advance_to(until);
  const auto error = [&](const LawUse& way, double step) {
    Simulation simulation = simulate(net, way, step);
    simulation.advance_to(until);
    double sum = 0.0;
    for (NodeIndex k = 0; k < simulation.node_count(); ++k)
      sum += (simulation.position(k) - reference.position(k)).squaredNorm();
    return std::sqrt(sum);
  };
  for (const double solver : {1.0, 2.0}) CHECK(error(cvode(1e-10, {{"linear_solver", solver}}), until) < 1e-7);
  CHECK(error(recurrent(newton, 1e-12), 0.001) / error(recurrent(newton, 1e-12), 0.0005) ==
        doctest::Approx(2.0).epsilon(0.1));
  const LawUse second = recurrent(newton, 1e-12, {{"theta", 0.5}}), verlet{"verlet", {}};
  CHECK(error(second, 0.002) / error(second, 0.001) == doctest::Approx(4.0).epsilon(0.1));
  CHECK(error(verlet, 0.001) > 1.8 * error(verlet, 0.0005));  // forces depend on velocities
}

TEST_CASE("bits are the same for every number of threads, under following pressures") {
  Network net = sail(5, -4.0, 1e-3);
  REQUIRE(net.nodes().size() > 8192);  // more than one unit
  Load load;
  load.faces = {{0, 1, 2}};
  load.traction = {1, 0, 0};
  load.course.frequency = 100.0;
  net.add_load(load);
  for (const LawUse& way : {single_sweep(), recurrent(coloured, 0.0, {{"sweeps", 2}})}) {
    std::vector<Eigen::MatrixXd> results;
    for (const unsigned threads : {1u, 2u, 3u}) {
      SimulationOptions options;
      options.time_step = 1e-3;
      options.integrator = way;
      options.threads = threads;
      Simulation simulation(net, plugins(), options);
      simulation.step();
      results.emplace_back(simulation.positions());
    }
    CHECK(results[0] == results[1]);
    CHECK(results[0] == results[2]);
  }
}
