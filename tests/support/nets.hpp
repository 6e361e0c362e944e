// Small networks in code, and integrators for them, for tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/simulation.hpp>

namespace springnet::testing {

inline constexpr Friction frictionless{Friction::Kind::none, 0.0};

// All plugins of the build tree, loaded once per program.
inline std::shared_ptr<const PluginHost> plugins() {
  static const auto host = std::make_shared<const PluginHost>(PluginHost::with_default_search());
  return host;
}

// Choices of the integrator "recurrent", by their numbers.
inline constexpr double synchronous = 0, wavefront = 1, block = 2, coloured = 3, newton = 4, automatic = 5;
inline constexpr std::array update_rules{"synchronous", "wavefront", "block", "coloured", "newton"};
// The option `update` of a rule by its name.
inline double update_named(std::string_view name) {
  return static_cast<double>(std::find(update_rules.begin(), update_rules.end(), name) - update_rules.begin());
}
inline constexpr double on_unsettled_error = 0, on_unsettled_accept = 1, on_unsettled_adapt = 2;

inline LawUse recurrent(double update, double force_tolerance, ParameterValues more = {}) {
  more["update"] = update;
  more["force_tolerance"] = force_tolerance;
  return {"recurrent", std::move(more)};
}
// One synchronous sweep per step: symplectic Euler.
inline LawUse single_sweep() { return {"recurrent", {{"update", synchronous}, {"sweeps", 1}}}; }
inline LawUse cvode(double relative_tolerance, ParameterValues more = {}) {
  more["relative_tolerance"] = relative_tolerance;
  return {"cvode", std::move(more)};
}

inline Simulation simulate(const Network& network, const LawUse& integrator, double time_step) {
  SimulationOptions options;
  options.time_step = time_step;
  options.integrator = integrator;
  options.threads = 1;
  return {network, plugins(), options};
}

inline LawUse generalized_alpha(double spectral_radius = 0.8) {
  return {"generalized_alpha", {{"spectral_radius", spectral_radius}, {"tolerance", 1e-12}}};
}

// Stiffness N/m; damping N s/m along the spring, 0: none.
inline Material damped(double stiffness, double damping) {
  Material material{LawUse{"linear", {{"stiffness", stiffness}}}, std::nullopt};
  if (damping > 0.0) material.viscosity = LawUse{"linear", {{"damping", damping}}};
  return material;
}

inline Node point(const Vector3& position, double mass = 1.0, const Vector3& velocity = Vector3::Zero()) {
  Node node;
  node.position = position;
  node.velocity = velocity;
  node.mass = mass;
  return node;
}

// Node 0, fixed at the origin, and node 1 on the x axis, `displacement` beyond the rest length 1 m.
inline Network oscillator(const Material& material, double mass, double displacement, double velocity = 0.0) {
  Network net;
  Node wall = point(Vector3::Zero());
  wall.fixed = true;
  net.add_node(wall);
  net.add_node(point({1.0 + displacement, 0, 0}, mass, {velocity, 0, 0}));
  net.add_spring(0, 1, net.add_material(material), 1.0);
  return net;
}

// Nodes 0 … count - 1 from `first` with distances `spacing`, each joined to the one before; nothing is fixed.
inline Network chain(std::uint32_t count, const Vector3& first, const Vector3& spacing, const Material& material,
                     double mass = 1.0) {
  Network net;
  const MaterialIndex index = net.add_material(material);
  for (std::uint32_t k = 0; k < count; ++k) {
    net.add_node(point(first + static_cast<double>(k) * spacing, mass));
    if (k > 0) net.add_spring(k - 1, k, index);
  }
  return net;
}

// The paper's cube: 64 nodes, 252 springs (axial and space-diagonal) of one stiffness and damping, falling on a floor.
inline Network cube(double stiffness, double damping, double gravity, double drop) {
  Network net;
  Lattice lattice;
  lattice.nodes = {4, 4, 4};
  lattice.origin = {0, 0, drop};
  lattice.diagonals = Diagonals::space;
  net.add_lattice("cube", lattice, Node{}, net.add_material(damped(stiffness, damping)));
  net.set_gravity({0, 0, -gravity});
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  return net;
}

}  // namespace springnet::testing
