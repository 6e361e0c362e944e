// Bodies that touch each other, for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Geometry>

#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"

namespace springnet::testing {

inline constexpr double g = 9.81;  // m/s^2
inline const LawUse verlet{"verlet", {}};
inline LawUse reference(double tolerance = 1e-10) { return {"cvode", {{"relative_tolerance", tolerance}}}; }
inline const Vector3 at_rest = Vector3::Zero();

// A body of one node, a ball.
inline NodeIndex add_ball(Network& net, const std::string& name, const Vector3& position, const Vector3& velocity,
                          double mass, double radius, bool fixed = false) {
  net.begin_body(name);
  Node node = point(position, mass, velocity);
  node.fixed = fixed;
  if (fixed) node.velocity.setZero();
  const NodeIndex k = net.add_node(node);
  net.end_body();
  net.set_extent(net.bodies().size() - 1, 0.0, radius);
  return k;
}

// All nodes of all bodies against each other.
inline void touch_all(Network& net, const Friction& friction, double restitution = 0.0) {
  BodyContact contact;
  contact.first.resize(net.nodes().size());
  std::iota(contact.first.begin(), contact.first.end(), 0u);
  contact.friction = friction;
  contact.restitution = restitution;
  net.add_contact(contact);
}

// Those of one body against those of another.
inline void touch(Network& net, std::size_t a, std::size_t b, const Friction& friction, double restitution = 0.0) {
  BodyContact contact;
  for (const auto& [body, side] : {std::pair(a, &contact.first), std::pair(b, &contact.second)}) {
    side->resize(net.bodies()[body].node_count);
    std::iota(side->begin(), side->end(), net.bodies()[body].first_node);
  }
  contact.friction = friction;
  contact.restitution = restitution;
  net.add_contact(contact);
}

// A square sheet of nodes^2 nodes in a plane through `centre` with these directions of its sides, each square of two
// triangles. Fixed, or with springs along the sides and diagonals.
inline std::size_t add_sheet(Network& net, const std::string& name, std::uint32_t nodes, double side,
                             const Vector3& centre, const Vector3& u, const Vector3& v, double thickness, double mass,
                             bool fixed, double stiffness = 100.0) {
  net.begin_body(name);
  const auto first = static_cast<NodeIndex>(net.nodes().size());
  const double spacing = side / (nodes - 1);
  for (std::uint32_t j = 0; j < nodes; ++j)
    for (std::uint32_t i = 0; i < nodes; ++i) {
      Node node = point(centre + (i * spacing - 0.5 * side) * u + (j * spacing - 0.5 * side) * v, mass);
      node.fixed = fixed;
      net.add_node(node);
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return first + i + nodes * j; };
  const MaterialIndex material = fixed ? 0 : net.add_material(damped(stiffness, 0.1));
  for (std::uint32_t j = 0; j < nodes; ++j)
    for (std::uint32_t i = 0; i < nodes; ++i) {
      if (i + 1 < nodes && j + 1 < nodes) {
        net.add_face({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        net.add_face({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
      if (fixed) continue;
      if (i + 1 < nodes) net.add_spring(at(i, j), at(i + 1, j), material);
      if (j + 1 < nodes) net.add_spring(at(i, j), at(i, j + 1), material);
      if (i + 1 < nodes && j + 1 < nodes) net.add_spring(at(i, j), at(i + 1, j + 1), material);
    }
  net.end_body();
  net.set_extent(net.bodies().size() - 1, thickness, 0.0);
  return net.bodies().size() - 1;
}

// A block of nodes^3 nodes, with springs along its edges and diagonals.
inline std::size_t add_block(Network& net, const std::string& name, std::uint32_t nodes, double spacing,
                             const Vector3& origin, const Vector3& velocity, double mass, double thickness,
                             double stiffness, double damping) {
  const Lattice lattice{{nodes, nodes, nodes}, Vector3::Constant(spacing), origin, Diagonals::all};
  net.add_lattice(name, lattice, point(Vector3::Zero(), mass, velocity), net.add_material(damped(stiffness, damping)));
  net.set_extent(net.bodies().size() - 1, thickness, 0.0);
  return net.bodies().size() - 1;
}

// N s, and about the origin N m s.
inline Vector3 momentum(const Network& net, const Simulation& s) {
  Vector3 sum = Vector3::Zero();
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) sum += net.nodes()[k].mass * s.velocity(k);
  return sum;
}
inline Vector3 angular_momentum(const Network& net, const Simulation& s) {
  Vector3 sum = Vector3::Zero();
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) sum += net.nodes()[k].mass * s.position(k).cross(s.velocity(k));
  return sum;
}

inline void advance(Simulation& s, int steps) {
  for (int i = 0; i < steps; ++i) s.step();
}

// Soft blocks of 27 nodes above each other, which fall onto a floor, all with this friction.
inline Network dropped_blocks(int count, double mass, double friction = 0.5) {
  Network net;
  for (int i = 0; i < count; ++i)
    add_block(net, "block " + std::to_string(i), 3, 0.1, {0.007 * (i % 2), 0.011 * (i % 3), 0.005 + 0.23 * i}, at_rest,
              mass, 0.01, 1500.0, 1.0);
  touch_all(net, {Friction::Kind::coulomb, friction});
  Plane floor;
  floor.friction = {Friction::Kind::coulomb, friction};
  net.add_plane(floor);
  net.set_gravity({0, 0, -9.81});
  return net;
}

// Two soft boxes of 8 nodes above each other on a floor, all with this friction. lift: m, of the first; apart: m, their
// middles; offset: m, of the upper one along x, and 0.6 times that along y.
inline Network boxes_above_each_other(double lift, double apart, double friction, double offset = 0.0) {
  Network net;
  for (std::size_t i = 0; i < 2; ++i) {
    const double k = static_cast<double>(i);
    const Lattice lattice{
        {2, 2, 2}, Vector3::Constant(0.1), {offset * k, 0.6 * offset * k, lift + apart * k}, Diagonals::space};
    net.add_lattice("box " + std::to_string(i), lattice, point(at_rest, 0.02), net.add_material(damped(1500.0, 1.0)));
    net.set_extent(i, 0.01, 0.0);
  }
  touch_all(net, {Friction::Kind::coulomb, friction});
  Plane floor;
  floor.friction = {Friction::Kind::coulomb, friction};
  net.add_plane(floor);
  net.set_gravity({0, 0, -g});
  return net;
}

// Balls of this mass and radius on each other, on a fixed one; node k is the k-th above it.
inline Network pile_of_balls(int count, double mass, double radius) {
  Network net;
  add_ball(net, "ground", {0, 0, 0}, at_rest, 1.0, radius, true);
  for (int i = 0; i < count; ++i)
    add_ball(net, "ball " + std::to_string(i), {0, 0, 2.0 * radius * (i + 1)}, at_rest, mass, radius);
  touch_all(net, frictionless);
  net.set_gravity({0, 0, -9.81});
  return net;
}

// That they rest where they were, and each touch carries the weight above it.
inline void check_pile(const Simulation& s, int count, double mass, double radius) {
  for (NodeIndex k = 1; k <= static_cast<NodeIndex>(count); ++k) {
    CAPTURE(k);
    CHECK(s.position(k)[2] == doctest::Approx(2.0 * radius * k).epsilon(1e-7));  // the tolerance of gaps, 1e-8
    CHECK(s.velocity(k).norm() <= 1e-6);
  }
  const std::vector<BodyTouch> touches = s.body_touches();
  REQUIRE(touches.size() == static_cast<std::size_t>(count));
  for (const BodyTouch& each : touches) {
    const NodeIndex above = std::max(each.nodes[0], each.nodes[1]);
    CAPTURE(above);
    CHECK(each.force.norm() == doctest::Approx((count + 1.0 - above) * mass * 9.81).epsilon(1e-5));
    CHECK(std::abs(each.normal[2]) == doctest::Approx(1.0));
  }
}

// That a run is the same in all bits for one thread and three, goes on so after a saved state, and where the network is
// extended by nothing; bodies touch after the first steps.
inline void check_bits(const Network& net, const LawUse& integrator, double time_step, int first, int then) {
  const auto start = [&](unsigned threads) {
    SimulationOptions options;
    options.time_step = time_step;
    options.integrator = integrator;
    options.threads = threads;
    return Simulation(net, plugins(), options);
  };
  Simulation one = start(1), three = start(3);
  advance(one, first);
  advance(three, first);
  REQUIRE(!one.body_touches().empty());
  CHECK(one.positions() == three.positions());
  const std::string saved = one.save();
  advance(one, then);
  Simulation later = start(1);
  later.restore(saved);
  REQUIRE(!later.body_touches().empty());
  advance(later, then);
  CHECK(one.positions() == later.positions());
  CHECK(one.events().size() == later.events().size());
  three.extend([](Network&) {});
  CHECK(!three.body_touches().empty());
  advance(three, then);
  CHECK(one.positions() == three.positions());
  CHECK(one.events().size() == three.events().size());
}

}  // namespace springnet::testing
