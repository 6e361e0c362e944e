// Runs that have everything a page can show, and are over in a moment.
#pragma once

#include <springnet/output.hpp>
#include <springnet/view.hpp>

#include "../bodies/bodies.hpp"
#include "nets.hpp"

namespace springnet::testing {

inline constexpr const char* bad_title = "A </script><b id=\"broken\"> title & \"quotes\"";

// A box of 4 x 4 x 4 nodes, with its surface, falls on a plane, a ball comes from above, a corner is held, another cut
// off; a weight on a rigid connection. A force pulls at a corner for a while.
inline Scene everything_to_see() {
  Scene scene;
  scene.title = bad_title;
  Network& network = scene.network;
  const MaterialIndex material =
      network.add_material({LawUse{"linear", {{"stiffness", 30.0}}}, LawUse{"linear", {{"damping", 1.0}}}});
  Node prototype;
  prototype.mass = 0.1;
  network.add_lattice("box", {{4, 4, 4}, Vector3::Ones(), Vector3(0.0, 0.0, 0.05), Diagonals::space}, prototype,
                      material);
  const auto upper = [](NodeIndex i, NodeIndex j) { return i + 4 * (j + 4 * 3); };
  Node weight;
  weight.position = Vector3(4.0, 3.0, 3.05);
  weight.mass = 0.1;
  network.add_rigid(upper(3, 3), network.add_node(weight));
  network.fix(upper(0, 3));
  network.set_gravity({0.0, 0.0, -1.0});
  network.add_plane({"ground", Vector3::Zero(), Vector3::UnitZ(), {}, std::nullopt});
  Motion down;
  down.times = {0.0, 1.0};
  down.displacements = {Vector3::Zero(), Vector3(0.0, 0.0, -1.0)};
  network.add_instrument({"ball", Vector3(1.5, 1.5, 4.6), Vector3(1.5, 1.5, 4.6), 0.8, {}, down});
  Cut cut{0.5, {}, {Vector3(2.5, -1.0, 2.4), Vector3(4.0, -1.0, 2.4), Vector3(4.0, 1.5, 2.4), Vector3(2.5, 1.5, 2.4)}};
  for (SpringIndex k = 0; k < network.springs().size(); ++k) {
    const Spring& spring = network.springs()[k];
    // Along an edge between two sides.
    if (spring.first == upper(0, 0) && spring.second == upper(1, 0)) cut.springs.push_back(k);
  }
  network.add_cut(cut);
  network.add_load({{upper(3, 3)}, Vector3(0.2, 0.2, 0.0), 0.0, 1.0});
  scene.duration = 1.5;
  scene.options.time_step = 0.025;
  scene.options.threads = 1;
  return scene;
}

// A beam of 3 x 3 x 8 nodes, held at one end, barely bent: a load on all nodes of the other end, and one on a single
// node for the first 0.24 s.
inline Scene barely_bent() {
  Scene scene;
  Network& network = scene.network;
  const MaterialIndex material =
      network.add_material({LawUse{"linear", {{"stiffness", 1e4}}}, LawUse{"linear", {{"damping", 10.0}}}});
  Node prototype;
  prototype.mass = 0.1;
  network.add_lattice("beam", {{8, 3, 3}, Vector3::Constant(0.1), Vector3(0.1, 0.2, 0.3), Diagonals::space}, prototype,
                      material);
  Load end, single;
  for (NodeIndex j = 0; j < 9; ++j) {
    network.fix(8 * j);
    end.nodes.push_back(8 * j + 7);
  }
  end.force = Vector3(0.0, 0.0, -0.01);
  network.add_load(end);
  single.nodes = {4};
  single.force = Vector3(0.0, 0.045, 0.0);
  single.from = 0.0;
  single.until = 0.24;
  network.add_load(single);
  scene.duration = 0.5;
  scene.options.time_step = 0.01;
  scene.options.threads = 1;
  return scene;
}

// A tetrahedron with elements that hold its volume and `sides` times one of its sides; it swells.
inline Scene with_elements(int sides = 1) {
  Scene scene;
  const MaterialIndex springs = scene.network.add_material({LawUse{"linear", {{"stiffness", 20.0}}}, std::nullopt});
  const MaterialIndex filling = scene.network.add_material({LawUse{"linear", {{"stiffness", 300.0}}}, std::nullopt});
  for (const Vector3& place : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)}) {
    Node node;
    node.position = place;
    node.mass = 0.1;
    scene.network.add_node(node);
  }
  for (NodeIndex a = 0; a < 4; ++a) {
    for (NodeIndex b = a + 1; b < 4; ++b) scene.network.add_spring(a, b, springs);
  }
  scene.network.add_element(Invariant::volume, {0, 1, 2, 3}, filling, 0.25);  // more than is there
  for (int k = 0; k < sides; ++k) scene.network.add_element(Invariant::area, {1, 2, 3}, filling, 0.5);
  scene.duration = 0.5;
  scene.options.time_step = 0.01;
  scene.options.threads = 1;
  return scene;
}

// Two balls of 0.5 kg on each other and on a moved one, which lifts them at 0.25 m/s: the forces between them are 10 N
// and 5 N, but at the start.
inline Scene lifted_balls() {
  Scene scene;
  Network& network = scene.network;
  const Vector3 velocity(0.0, 0.0, 0.25);
  for (int k = 0; k < 3; ++k) add_ball(network, "ball " + std::to_string(k), {0.0, 0.0, 0.2 * k}, velocity, 0.5, 0.1);
  touch_all(network, frictionless);
  network.set_gravity({0.0, 0.0, -10.0});
  Motion lift;
  lift.interpolation = Motion::Interpolation::linear;
  lift.times = {0.0, 1.0};
  lift.displacements = {Vector3::Zero(), velocity};
  network.add_move({{0}, lift});
  scene.duration = 0.5;
  scene.options.time_step = 0.0625;
  scene.options.integrator = verlet;
  scene.options.threads = 1;
  return scene;
}

// A grid of springs that is pulled apart: one half yields, some of the other half take damage, the rest has no memory.
inline Scene with_memory() {
  Scene scene;
  Network& network = scene.network;
  const std::vector<MaterialIndex> materials{
      network.add_material({LawUse{"plastic", {{"stiffness", 40.0}, {"yield_tension", 1.0}, {"relaxation_time", 0.05}}},
                            LawUse{"linear", {{"damping", 0.5}}}}),
      network.add_material(
          {LawUse{
               "damaging",
               {{"stiffness", 40.0}, {"threshold_strain", 0.02}, {"softening_strain", 2.0}, {"relaxation_time", 0.05}}},
           std::nullopt}),
      network.add_material({LawUse{"linear", {{"stiffness", 40.0}}}, LawUse{"linear", {{"damping", 0.5}}}})};
  constexpr NodeIndex wide = 8, high = 5;
  for (NodeIndex j = 0; j < high; ++j) {
    for (NodeIndex i = 0; i < wide; ++i) {
      Node node;
      node.position = Vector3(i, j, 0.0);
      node.mass = 0.1;
      node.fixed = i == 0;
      network.add_node(node);
    }
  }
  const auto number = [](NodeIndex i, NodeIndex j) { return i + wide * j; };
  for (NodeIndex j = 0; j < high; ++j) {
    for (NodeIndex i = 0; i < wide; ++i) {
      const MaterialIndex material = materials[i < 4 ? 0 : j % 2 == 0 ? 1 : 2];
      if (i + 1 < wide) network.add_spring(number(i, j), number(i + 1, j), material);
      if (j + 1 < high) network.add_spring(number(i, j), number(i, j + 1), material);
      if (i + 1 < wide && j + 1 < high) network.add_spring(number(i, j), number(i + 1, j + 1), material);
    }
  }
  Motion pull;
  pull.times = {0.0, 1.0};
  pull.displacements = {Vector3::Zero(), Vector3(1.5, 0.0, 0.0)};
  std::vector<NodeIndex> right;
  for (NodeIndex j = 0; j < high; ++j) right.push_back(number(wide - 1, j));
  network.add_move({right, pull});
  scene.title = "A grid that yields and tears";
  scene.duration = 1.0;
  scene.options.time_step = 0.02;
  scene.options.threads = 1;
  return scene;
}

}  // namespace springnet::testing
