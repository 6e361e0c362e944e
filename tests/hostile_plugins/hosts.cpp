#include "hosts.hpp"

#include <cmath>
#include <memory>

#include <fmt/format.h>

#include <springnet/plugin_host.hpp>
#include <springnet/printable.hpp>

#include "nets.hpp"

namespace springnet::testing {
namespace {

std::string check_state(const Simulation& simulation) {
  if (!std::isfinite(simulation.time())) return "the time is not finite";
  if (!simulation.positions().allFinite() || !simulation.velocities().allFinite()) return "the state is not finite";
  return {};
}

std::string check_error(const Error& error, const Expectation& expected) {
  const std::string text = error.what();
  if (text.size() < 20) return fmt::format("an error of few words: {}", text);
  if (printable_message(text) != text) return fmt::format("an error with control characters: {}", printable(text, 400));
  if (text.find(expected.names) == std::string::npos)
    return fmt::format("no '{}' in the error: {}", expected.names, text);
  if (expected.kind && error.kind() != *expected.kind)
    return fmt::format("an error of kind {}: {}", static_cast<int>(error.kind()), text);
  return {};
}

}  // namespace

std::string run_with(const springnet_plugin& plugin, const Network& network, const SimulationOptions& options,
                     const Expectation& expected) {
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  if (!host->add(plugin)) return "the plugin was refused: " + host->refusals().back().reason;
  std::optional<Simulation> simulation;
  try {
    simulation.emplace(network, host, options);
    for (int k = 1; k <= 4; ++k) {
      if (k == 3)
        simulation->advance_to(3 * options.time_step);
      else
        simulation->step();
      if (std::abs(simulation->time() - k * options.time_step) > 1e-3 * options.time_step)
        return fmt::format("{} steps of {} s are said to be done at {} s", k, options.time_step, simulation->time());
      if (std::string wrong = check_state(*simulation); !wrong.empty()) return wrong;
      static_cast<void>(simulation->forces());
      static_cast<void>(simulation->reaction(0));
      static_cast<void>(simulation->potential_energy());
      static_cast<void>(simulation->tension(0));
    }
  } catch (const Error& error) {
    if (std::string wrong = check_error(error, expected); !wrong.empty()) return wrong;
    if (!simulation) return {};
    // What was reached is kept, and another step neither crashes nor hangs.
    if (std::string wrong = check_state(*simulation); !wrong.empty()) return wrong + " after " + error.what();
    try {
      simulation->step();
    } catch (const Error&) {
      // The same fault once more.
    }
    return check_state(*simulation);
  }
  for (const std::string& note : simulation->notes())
    if (printable_message(note) != note) return "a note with control characters";
  return expected.fails ? "no error" : "";
}

Network row(const Material& material, const LawUse& neuron, bool large) {
  Network net;
  const MaterialIndex index = net.add_material(material);
  Node node;
  if (!neuron.id.empty()) node.neuron = net.add_neuron(neuron);
  if (large) {
    Lattice lattice;
    lattice.nodes = {2, 2, 4500};  // more than one unit
    net.add_lattice("rod", lattice, node, index);
    net.add_plane({"floor", Vector3(0, 0, -1), Vector3::UnitZ()});
    return net;
  }
  for (NodeIndex k = 0; k < 6; ++k) {
    node.position = {1.01 * k, 0.1 * (k % 2), 0};
    node.velocity = {k == 5 ? 0.5 : 0.0, 0.1, 0};
    node.fixed = k == 0;
    if (node.fixed) node.velocity = Vector3::Zero();
    net.add_node(node);
    if (k > 0) net.add_spring(k - 1, k, index);
  }
  net.add_plane({"floor", Vector3(0, 0, -1), Vector3::UnitZ()});
  return net;
}

}  // namespace springnet::testing
