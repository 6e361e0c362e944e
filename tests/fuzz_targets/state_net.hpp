// The net whose saved states are read: a little of everything that a state has parts for.
#pragma once

#include <memory>

#include <springnet/simulation.hpp>

namespace springnet::testing {

inline Network state_net() {
  Network net;
  const MaterialIndex soft =
      net.add_material({LawUse{"linear", {{"stiffness", 50.0}}}, LawUse{"linear", {{"damping", 0.5}}}});
  net.add_lattice("block", {{2, 2, 2}, Vector3::Ones(), {0, 0, 0.05}, Diagonals::face}, {}, soft);
  const NodeIndex held = net.add_node({.position = {3, 0, 2}, .mass = 1.0}),
                  end = net.add_node({.position = {4, 0, 2}, .velocity = {1, 0, 0}, .mass = 1.0}),
                  rod = net.add_node({.position = {5, 0, 2}, .mass = 1.0});
  const SpringIndex muscle =
      net.add_spring(held, end, net.add_material({LawUse{"muscle", {{"strength", 20.0}, {"maximum_speed", 3.0}}}, {}}));
  net.add_spring(held, end, net.add_material({LawUse{"maxwell", {{"stiffness", 50.0}, {"relaxation_time", 0.1}}}, {}}));
  net.add_spring(held, end, net.add_material({LawUse{"rupturing", {{"stiffness", 50.0}, {"strength", 3.0}}}, {}}));
  net.add_rigid(end, rod);
  net.add_element(Invariant::angle, {0, 1, 3}, net.add_material({LawUse{"linear", {{"stiffness", 0.5}}}, {}}));
  Input drive;
  drive.input = "activation";
  drive.name = "drive";
  drive.springs = {muscle};
  drive.signal.mean = 0.4;
  net.add_input(drive);
  Motion down;
  down.times = {0.0, 0.5};
  down.displacements = {{0, 0, 0}, {0, 0.2, -0.4}};
  net.add_move({{held}, down});
  Plane ramp{"ramp", {0, 0, -0.01}, {0.1, 0, 1}};
  ramp.friction = {Friction::Kind::coulomb, 0.2};
  net.add_plane(ramp);
  Instrument ball{"ball", {0.5, 0.5, 1.7}, {0.5, 0.5, 1.7}, 0.5};
  ball.motion = down;
  net.add_instrument(ball);
  Load wind;
  wind.nodes = {6};
  wind.force = {1, 0, 0};
  wind.from = 0.05;
  wind.faces = {net.faces()[0]};
  wind.pressure = 0.1;
  wind.follow = true;
  net.add_load(wind);
  net.add_cut({0.06, {3}, {}});
  net.set_gravity({0, 0, -9.81});
  return net;
}

inline Simulation state_simulation() {
  static const auto plugins = std::make_shared<const PluginHost>(PluginHost::with_default_search());
  static const auto net = std::make_shared<const Network>(state_net());
  SimulationOptions options;
  options.integrator = {"recurrent", {}};
  options.time_step = 0.02;
  options.threads = 1;
  options.dissipated_energy = true;
  return {net, plugins, options};
}

}  // namespace springnet::testing
