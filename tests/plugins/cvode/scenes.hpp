// Networks of a few nodes with closed forms, simulated with cvode.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/simulation.hpp>

namespace cvode_test {

using namespace springnet;

inline std::shared_ptr<const PluginHost> plugins() {
  static const auto host = std::make_shared<const PluginHost>(PluginHost::with_default_search());
  return host;
}

// Choices of the component, in its order.
enum Method { bdf, adams };
enum Solver { automatic, direct, krylov, none };

inline SimulationOptions options(double tolerance, double time_step, Method method = bdf, Solver solver = automatic) {
  SimulationOptions result;
  result.time_step = time_step;
  result.integrator = {"cvode", {{"relative_tolerance", tolerance}, {"method", method}, {"linear_solver", solver}}};
  return result;
}

inline Simulation simulate(const Network& network, const SimulationOptions& options) {
  return Simulation(network, plugins(), options);
}

inline Material linear(double stiffness, double damping = 0.0) {
  Material material;
  material.spring = LawUse{"linear", {{"stiffness", stiffness}}};
  if (damping > 0.0) material.viscosity = LawUse{"linear", {{"damping", damping}}};
  return material;
}

inline Node node(const Vector3& position, double mass = 1.0, const Vector3& velocity = Vector3::Zero()) {
  Node result;
  result.position = position;
  result.velocity = velocity;
  result.mass = mass;
  return result;
}

// Node 0 is fixed at the origin; node 1 hangs on a spring of 1 m in the direction x, stretched by `stretch`.
inline Network oscillator(const Material& material, double mass, double stretch, double speed = 0.0) {
  Network network;
  const NodeIndex wall = network.add_node(node(Vector3::Zero()));
  network.fix(wall);
  const NodeIndex body = network.add_node(node({1.0 + stretch, 0, 0}, mass, {speed, 0, 0}));
  network.add_spring(wall, body, network.add_material(material), 1.0);
  return network;
}

// A lattice with all kinds of springs, in motion: it falls on the plane z = 0 and drifts along it.
inline Network falling_lattice(std::uint32_t side, double stiffness, double damping) {
  Network network;
  Lattice lattice;
  lattice.nodes = {side, side, side};
  lattice.origin = {0, 0, 0.05};
  lattice.diagonals = Diagonals::all;
  network.add_lattice("block", lattice, node(Vector3::Zero(), 1.0, {0.1, 0, -0.5}),
                      network.add_material(linear(stiffness, damping)));
  network.set_gravity({0, 0, -1});
  Plane plane;
  plane.name = "ground";
  network.add_plane(plane);
  return network;
}

}  // namespace cvode_test
