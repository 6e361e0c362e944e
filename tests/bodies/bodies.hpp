// Bodies that touch each other, for tests.
#pragma once

#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"

namespace springnet::testing {

inline const Friction frictionless{Friction::Kind::none, 0.0};
inline const LawUse verlet{"verlet", {}};
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

}  // namespace springnet::testing
