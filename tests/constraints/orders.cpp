// Orders of convergence of every rule against the reference, where rigid connections, contact between events and moved
// nodes bind the motion.

#include <doctest/doctest.h>

#include <functional>

#include "schemes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// A frame of springs with rigid struts, swinging from a rigid rod.
Network rigid_and_elastic() {
  Network net;
  const MaterialIndex elastic = net.add_material(damped(60.0, 0.4));
  const MaterialIndex viscous = net.add_material({std::nullopt, LawUse{"relative", {{"damping", 0.3}}}});
  Node pivot = point(Vector3::Zero());
  pivot.fixed = true;
  net.add_node(pivot);
  net.add_node(point({0.6, 0, -0.1}, 0.5));
  net.add_node(point({1.1, 0.2, -0.2}, 0.4, {0, 0.3, 0}));
  net.add_node(point({0.9, -0.3, -0.7}, 0.6));
  net.add_node(point({0.3, 0.1, -0.8}, 0.3, {0.2, 0, 0}));
  net.add_rigid(0, 1);
  net.add_spring(1, 2, elastic);
  net.add_rigid(2, 3);
  net.add_spring(3, 4, elastic);
  net.add_spring(4, 1, elastic);
  net.add_spring(2, 4, viscous);
  net.set_gravity({0, 0, -9.81});
  return net;
}

// A spring pair on a tilted plane, without friction or with Coulomb's: both nodes slide from the start on.
Network sliding_on_plane(const Friction& friction) {
  Network net;
  net.add_node(point({0, 0, 0}, 0.5, {0.9, 0.4, 0}));
  net.add_node(point({1.1, 0, 0}, 0.8, {0.7, -0.2, 0}));
  net.add_spring(0, 1, net.add_material(damped(40.0, 0.2)), 1.0);
  net.set_gravity({3.0, 0.5, -9.0});
  Plane plane;
  plane.friction = friction;
  net.add_plane(plane);
  return net;
}

// A node that slides down a sphere which moves, drawn by a spring from a fixed node.
Network sliding_on_sphere() {
  Network net;
  net.add_node(point({0.1, 0.05, std::sqrt(1.0 - 0.0125)}, 0.5));
  Node wall = point({1.5, 0, 0.9});
  wall.fixed = true;
  net.add_node(wall);
  net.add_spring(0, 1, net.add_material(damped(2.0, 0.1)));
  net.set_gravity({0, 0, -9.81});
  Instrument sphere;
  sphere.friction.kind = Friction::Kind::none;
  sphere.motion.emplace();
  sphere.motion->amplitude = {0.02, 0, 0.01};
  sphere.motion->frequency = 0.5;
  net.add_instrument(sphere);
  return net;
}

// A chain of springs whose ends are moved, one by a sinusoid, one by a table, with a rigid rod on the way.
Network moved_ends() {
  Network net;
  const MaterialIndex material = net.add_material(damped(80.0, 0.3));
  for (NodeIndex k = 0; k < 5; ++k) net.add_node(point({0.5 * k, 0, 0}, 0.3));
  for (NodeIndex k = 0; k < 4; ++k) {
    if (k == 2)
      net.add_rigid(k, k + 1);
    else
      net.add_spring(k, k + 1, material);
  }
  Move left, right;
  left.nodes = {0};
  left.motion.amplitude = {0.0, 0.05, 0.1};
  left.motion.frequency = 1.2;
  net.add_move(left);
  right.nodes = {4};
  right.motion.times = {0.0, 0.8, 1.6};
  right.motion.displacements = {Vector3::Zero(), {0.1, 0, 0.2}, {0.0, 0.1, 0.0}};
  net.add_move(right);
  net.set_gravity({0, 0, -2.0});
  return net;
}

struct Example {
  const char* name;
  Network net;
  double until;      // s, before anything touches, leaves, sticks
  double time_step;  // s, below the limit of the synchronous rule
};

}  // namespace

TEST_CASE("theta 1 is of first, theta 1/2 and verlet are of second order, with all that binds the motion") {
  const Example examples[] = {
      {"rigid and elastic", rigid_and_elastic(), 0.6, 0.01},
      {"sliding on a plane", sliding_on_plane({Friction::Kind::none, 0.0}), 0.5, 0.01},
      {"sliding on a plane with friction", sliding_on_plane({Friction::Kind::coulomb, 0.15}), 0.4, 0.01},
      {"sliding on a sphere", sliding_on_sphere(), 0.4, 0.01},
      {"moved ends", moved_ends(), 0.7, 0.01},
  };
  for (const Example& example : examples) {
    Simulation reference = simulate(example.net, cvode(1e-10), example.time_step);
    reference.advance_to(example.until);
    for (const Scheme& scheme : stepping_schemes(1e-10)) {
      INFO(example.name << ": " << scheme.name);
      double error[2];
      for (int i = 0; i < 2; ++i) {
        Simulation simulation = simulate(example.net, scheme.integrator, example.time_step / (1 << i));
        simulation.advance_to(example.until);
        error[i] = distance(simulation, reference);
        CHECK(worst_length(example.net, simulation) <= 1e-8);
      }
      const double order = std::log2(error[0] / error[1]);
      CAPTURE(error[0]);
      CAPTURE(error[1]);
      // The next term of the error is worth some per cent of an order at these steps.
      CHECK(order > scheme.order - 0.2);
      CHECK(order < scheme.order + 0.5);
    }
  }
}
