// The balance of momentum over a step of the network: gravity, reactions over the step, and impulses.

#include <doctest/doctest.h>

#include <cmath>

#include "run.hpp"
#include "scenes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct Example {
  std::string name;
  Network net;
  double until;  // s
};

// A node that slides in a groove, whose sides are rough, against a wall.
Network in_groove(const Friction& friction) {
  Network net;
  net.add_node(point({0, 0, 0.03}, 0.7, {0.8, 0.1, 0}));
  net.set_gravity({2.0, 0, -9.0});
  const Vector3 normals[] = {{0, 0.6, 0.9}, {0, -0.7, 0.6}, {-1, 0, 0}};
  for (const Vector3& normal : normals) {
    Plane plane;
    plane.normal = normal;
    if (normal.x() != 0.0) plane.point = {0.4, 0, 0};
    plane.friction = friction;
    net.add_plane(plane);
  }
  return net;
}

// A tetrahedron of rods that hangs on a fixed node and on one that moves, and swings onto a sphere and a floor.
Network swinging(const Friction& friction) {
  Network net;
  Node wall = point({-0.4, 0, 0.8}, 0.5);
  wall.fixed = true;
  const NodeIndex fixed = net.add_node(wall), moved = net.add_node(point({0.9, 0.1, 1.1}, 0.6));
  Move hand{{moved}, {}};
  hand.motion.amplitude = {0.1, 0.2, 0.1};
  hand.motion.frequency = 0.7;
  net.add_move(hand);
  const Vector3 places[] = {{0, 0, 0.8}, {0.5, 0, 0.8}, {0.2, 0.4, 0.7}, {0.25, 0.15, 1.1}};
  for (const Vector3& place : places) net.add_node(point(place, 0.3));
  for (NodeIndex a = 2; a < 6; ++a)
    for (NodeIndex b = a + 1; b < 6; ++b) net.add_rigid(a, b);
  net.add_rigid(fixed, 2);
  net.add_spring(moved, 3, net.add_material(damped(40.0, 0.3)));
  const NodeIndex last = net.add_node(point({1.2, 0.1, 0.8}, 0.2));
  net.add_rigid(moved, last);
  net.set_gravity({0, 0, -6});
  Plane plane;
  plane.friction = friction;
  net.add_plane(plane);
  Instrument sphere;
  sphere.first = sphere.second = {0.4, 0.1, 0.1};
  sphere.radius = 0.4;
  sphere.friction = friction;
  sphere.turn.emplace();
  sphere.turn->rate = 0.8;
  net.add_instrument(sphere);
  return net;
}

std::vector<Example> examples() {
  const Friction rough{Friction::Kind::coulomb, 0.2}, held{Friction::Kind::held, 0.0};
  return {{"sphere", on_sphere(), 3.0},
          {"landing on a sphere", thrown_on_sphere(frictionless), 1.2},
          {"landing on a rough sphere", thrown_on_sphere(rough), 1.2},
          {"landing on a capsule", thrown_on_capsule(frictionless), 1.2},
          {"landing on a rough capsule", thrown_on_capsule(rough), 1.2},
          {"pair", thrown_pair(), 0.6},
          {"box", thrown_box(), 0.6},
          {"shaken plane", on_shaken_plane(), 0.9},
          {"shaken oscillator", shaken_oscillator(), 3.0},
          {"groove", in_groove(frictionless), 0.8},
          {"rough groove", in_groove(rough), 0.8},
          {"swinging", swinging(frictionless), 0.8},
          {"swinging, rough", swinging(rough), 0.8},
          {"swinging, held", swinging(held), 0.8}};
}

// Of fixed nodes, too: their reactions balance their weight.
double total_mass(const Network& net) {
  double mass = 0.0;
  for (const Node& node : net.nodes()) mass += node.mass;
  return mass;
}

}  // namespace

TEST_CASE("a step of the network changes momentum by gravity, reactions over the step and impulses alone") {
  constexpr double threshold = 1e-9, h = 0.002;
  for (const Example& example : examples()) {
    const Network& net = example.net;
    for (const Scheme& scheme : stepping_schemes(threshold)) {
      // Their reactions are those of a time, not of a step.
      if (scheme.name == "verlet" || scheme.name == "generalized_alpha") continue;
      INFO(example.name << ": " << scheme.name);
      const double theta = scheme.order == 1.0 ? 1.0 : 0.5;
      Simulation s = simulate(net, scheme.integrator, h);
      double worst = 0.0, at = 0.0;
      while (s.time() < example.until - 0.5 * h) {
        const Vector3 before = s.momentum();
        Vector3 expected = h * total_mass(net) * net.gravity();
        for (NodeIndex k = 0; k < s.node_count(); ++k)
          expected += h * (1.0 - theta) * s.reaction(k) - s.contact_impulse(k);
        s.step();
        for (NodeIndex k = 0; k < s.node_count(); ++k) expected += h * theta * s.reaction(k) + s.contact_impulse(k);
        const double error = (s.momentum() - before - expected).norm();
        if (error > worst) at = s.time();
        worst = std::max(worst, error);
      }
      // Impulses on obstacles are opposite to those on their nodes.
      Vector3 sum = Vector3::Zero();
      for (std::size_t j = 0; j < s.surface_count(); ++j) sum += s.surface_impulse(j);
      for (NodeIndex k = 0; k < s.node_count(); ++k)
        if (!net.nodes()[k].fixed) sum += s.contact_impulse(k);
      CHECK(sum.norm() <= 1e-12);
      CAPTURE(at);
      CHECK(worst <= h * threshold * static_cast<double>(s.node_count()) + 1e-13);
    }
  }
}
