// Nets that fall on surfaces, and what is learned of them.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/motion_derivatives.hpp>

#include "motion_loss.hpp"
#include "nets.hpp"
#include "uneven.hpp"

namespace springnet::testing {

inline constexpr Friction held{Friction::Kind::held, 0.0}, smooth{Friction::Kind::none, 0.0},
    rough{Friction::Kind::coulomb, 0.3};

inline Plane floor_with(const Friction& friction, const Vector3& normal = Vector3::UnitZ(), double restitution = 0.0) {
  Plane plane;
  plane.name = "floor";
  plane.normal = normal;
  plane.friction = friction;
  plane.restitution = restitution;
  return plane;
}

// Eight nodes as a block, no two alike.
inline Network block_at(const Vector3& place, const Vector3& velocity, std::uint64_t seed = 5) {
  Network net;
  Lattice lattice;
  lattice.nodes = {2, 2, 2};
  lattice.spacing = {0.2, 0.2, 0.2};
  lattice.origin = place;
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(200.0, 2.0)));
  make_uneven(net, seed, 0.02, 0.1, [&](const Vector3&) { return velocity; });
  net.set_gravity({0, 0, -9.81});
  return net;
}

// Of springs, loads and nodes that are not fixed.
inline std::vector<LearnedValues> values_of(const Network& net) {
  const std::size_t springs = net.springs().size(), nodes = net.nodes().size();
  std::vector<std::uint32_t> moving = all(nodes);
  std::erase_if(moving, [&](std::uint32_t k) { return net.nodes()[k].fixed; });
  std::vector<LearnedValues> result;
  if (springs > 0)
    result = {{LearnedValues::Kind::spring_parameter, false, "stiffness", all(springs)},
              {LearnedValues::Kind::viscosity_parameter, false, "damping", all(springs)},
              {LearnedValues::Kind::rest_length, false, "", all(springs)}};
  if (!net.loads().empty()) result.push_back({LearnedValues::Kind::load, false, "", all(net.loads().size())});
  result.push_back({LearnedValues::Kind::mass, false, "", moving});
  result.push_back({LearnedValues::Kind::initial_velocity, false, "", moving});
  return result;
}

}  // namespace springnet::testing
