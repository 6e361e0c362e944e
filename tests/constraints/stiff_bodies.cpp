// Bodies whose nodes vibrate many times within a time step meet surfaces: a node that would reach a surface in the
// step, and be pushed off where it stops, is neither free nor in contact.

#include <doctest/doctest.h>

#include <cmath>

#include "schemes.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("stiff bodies slide down a smooth slope in steps of many of their vibrations") {
  const Vector3 normal = Vector3(0.25, 0.12, 1.0).normalized(), gravity(-2.0, -1.0, -9.4);
  constexpr double mass = 1.5e-4, h = 1.0 / 30.0;
  for (const double stiffness : {50.0, 135.0}) {  // stiffness h^2 / mass: 370 and 1000
    for (const double damping : {0.002, 0.02}) {
      CAPTURE(stiffness);
      CAPTURE(damping);
      Network net;
      Lattice shape;
      shape.nodes = {5, 4, 3};
      shape.spacing = Vector3::Constant(0.01);
      shape.origin = {0, 0, 0.03};
      shape.diagonals = Diagonals::all;
      net.add_lattice("block", shape, point(Vector3::Zero(), mass), net.add_material(damped(stiffness, damping)));
      net.set_gravity(gravity);
      Plane plane;
      plane.normal = normal;
      plane.friction = {Friction::Kind::none, 0.0};
      net.add_plane(plane);
      constexpr double tolerance = 1e-9;  // N
      SimulationOptions options;
      options.time_step = h;
      options.integrator = recurrent(newton, tolerance);
      Simulation simulation(std::make_shared<const Network>(net), plugins(), options);
      constexpr int steps = 30;
      for (int step = 0; step < steps; ++step) {
        simulation.step();
        for (NodeIndex k = 0; k < net.nodes().size(); ++k) REQUIRE(normal.dot(simulation.position(k)) > -1e-12);
      }
      // Whatever the surface does, it acts along its normal: along it the momentum is that of gravity. Each node may
      // keep the threshold of force unbalanced in each step.
      Vector3 momentum = Vector3::Zero();
      for (NodeIndex k = 0; k < net.nodes().size(); ++k) momentum += mass * simulation.velocity(k);
      const auto total = static_cast<double>(net.nodes().size());
      const Vector3 off = momentum - total * mass * steps * h * gravity;
      CHECK((off - normal * normal.dot(off)).norm() < total * tolerance * steps * h);
      CHECK(off.norm() > 1e-3);  // it has come to the surface
    }
  }
}
