// A net in which everything changes, and the comparison of two simulations to the last bit.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <string>

#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"

namespace springnet::testing {

// A cube that falls on a ramp with friction, under a ball that moves: springs with memory, springs that break, muscles,
// a load that comes and goes, a moved node, a rigid connection, a cut.
inline Network eventful() {
  Network net = cube(300.0, 2.0, 2.0, 1e-3);
  Plane ramp{"ramp", {0, 0, -0.02}, Vector3(0.3, 0, 1).normalized()};
  ramp.friction = {Friction::Kind::coulomb, 0.2};
  net.add_plane(ramp);
  Instrument ball{"ball", {1.5, 1.5, 3.6}, {1.5, 1.5, 3.6}, 0.5};
  Motion down;
  down.times = {0.0, 0.5};
  down.displacements = {{0, 0, 0}, {0, 0.2, -0.4}};
  ball.motion = down;
  net.add_instrument(ball);
  const auto add = [&net](const Vector3& from, const LawUse& law) {
    const NodeIndex a = net.add_node(point(from)), b = net.add_node(point(from + Vector3(1, 0, 0), 1.0, {0.8, 0, 0}));
    return net.add_spring(a, b, net.add_material({law, LawUse{"linear", {{"damping", 0.5}}}}));
  };
  add({6, 0, 2}, {"maxwell", {{"stiffness", 50.0}, {"relaxation_time", 0.1}}});
  add({6, 0, 3}, {"rupturing", {{"stiffness", 50.0}, {"strength", 3.0}}});
  const SpringIndex muscle = add({6, 0, 4}, {"muscle", {{"strength", 20.0}, {"maximum_speed", 3.0}}});
  Input activation;
  activation.name = "drive";
  activation.input = "activation";
  activation.springs = {muscle};
  activation.signal.mean = 0.4;
  activation.signal.amplitude = 0.3;
  activation.signal.frequency = 1.5;
  net.add_input(activation);
  Load wind;
  wind.nodes = {60, 61};
  wind.force = {1.0, 0.5, 0};
  wind.from = 0.07;
  wind.until = 0.33;
  net.add_load(wind);
  const NodeIndex held = net.add_node(point({8, 8, 8})), hanging = net.add_node(point({8, 8, 7}));
  net.add_rigid(held, hanging);
  Move move;
  move.nodes = {held};
  move.motion = down;
  net.add_move(move);
  net.add_cut({0.29, {3, 17, 40, 90}, {}});
  return net;
}

inline SimulationOptions with(LawUse integrator, double time_step, unsigned threads = 1) {
  SimulationOptions options;
  options.integrator = std::move(integrator);
  options.time_step = time_step;
  options.threads = threads;
  return options;
}

inline bool step(Simulation& simulation) {
  try {
    simulation.step();
    return true;
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::simulation);
    return false;
  }
}

inline bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
inline bool same_bits(const Vector3& a, const Vector3& b) {
  return same_bits(a[0], b[0]) && same_bits(a[1], b[1]) && same_bits(a[2], b[2]);
}

// Everything that can be asked of two simulations. Empty: it is the same; else what is not.
inline std::string difference(const Simulation& a, const Simulation& b) {
  if (!same_bits(a.time(), b.time()) || a.steps() != b.steps() || a.sweeps() != b.sweeps())
    return "time, steps or sweeps";
  for (NodeIndex k = 0; k < a.node_count(); ++k) {
    if (!same_bits(a.position(k), b.position(k))) return "position";
    if (!same_bits(a.velocity(k), b.velocity(k))) return "velocity";
    if (!same_bits(a.force(k), b.force(k))) return "force";
    if (!same_bits(a.reaction(k), b.reaction(k))) return "reaction";
    if (!same_bits(a.contact_impulse(k), b.contact_impulse(k))) return "contact impulse";
    if (a.held(k) != b.held(k) || a.touching(k) != b.touching(k) || a.surfaces_of(k) != b.surfaces_of(k))
      return "contact";
  }
  for (SpringIndex s = 0; s < a.spring_count(); ++s)
    if (a.alive(s) != b.alive(s) || !same_bits(a.tension(s), b.tension(s)) ||
        a.internal_states(s) != b.internal_states(s))
      return "spring";
  for (ElementIndex e = 0; e < a.element_count(); ++e)
    if (a.element_alive(e) != b.element_alive(e) || !same_bits(a.element_force(e), b.element_force(e)))
      return "element";
  for (std::size_t s = 0; s < a.surface_count(); ++s)
    if (!same_bits(a.surface_position(s), b.surface_position(s)) ||
        !same_bits(a.surface_velocity(s), b.surface_velocity(s)) ||
        !same_bits(a.surface_impulse(s), b.surface_impulse(s)))
      return "surface";
  if (a.events().size() != b.events().size()) return "number of events";
  for (std::size_t k = 0; k < a.events().size(); ++k) {
    const Event &x = a.events()[k], &y = b.events()[k];
    if (x.kind != y.kind || !same_bits(x.time, y.time) || x.index != y.index || x.element != y.element ||
        x.surface != y.surface || !same_bits(x.impulse, y.impulse))
      return "event";
  }
  if (a.notes() != b.notes()) return "notes";
  if (a.statistics() != b.statistics()) return "statistics";
  if (!same_bits(a.dissipated_energy(), b.dissipated_energy())) return "dissipated energy";
  return {};
}

// Every method and update rule that the plugins of this project have, with time steps that suit eventful().
inline std::vector<SimulationOptions> all_methods() {
  std::vector<SimulationOptions> result;
  for (const double theta : {1.0, 0.5})
    for (const double rule : {synchronous, wavefront, block, coloured, newton, automatic})
      result.push_back(with(recurrent(rule, 0.0, {{"theta", theta}, {"unsettled", on_unsettled_adapt}}),
                            rule == synchronous || rule == wavefront ? 0.005 : 0.025));
  result.push_back(with(recurrent(newton, 0.0, {{"theta", 0.5}, {"events", 1}}), 0.02));
  result.push_back(with(cvode(1e-6), 0.01));
  result.push_back(with({"verlet", {{"substeps", 10}}}, 0.01));
  result.push_back(with(generalized_alpha(), 0.02));
  return result;
}

}  // namespace springnet::testing
