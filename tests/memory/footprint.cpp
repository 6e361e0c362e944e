// What a network and its simulation take of memory. The program is one of its own, so that nothing else takes any.
#include <doctest/doctest.h>
#include <springnet/simulation.hpp>

#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <random>
#include <string>

#include "nets.hpp"

using namespace springnet;

namespace {

// Bytes; the system tells kilobytes.
std::optional<double> status(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    double kilobytes = 0.0;
    if (word == key + ":" && file >> kilobytes) return 1024.0 * kilobytes;
  }
  return std::nullopt;
}

// From here on the peak is that of what follows.
bool forget_peak() {
  std::ofstream file("/proc/self/clear_refs");
  file << "5" << std::flush;
  return file.good();
}

// What docs/propagation.md promises for springs of one material, in bytes: 64 a spring and 200 a node while it steps,
// and at most half more while it loads. A spring takes 16 in the network (ends, rest length), 4 for the row of its
// parameters, 8 for its ends in the engine's numbers, 8 for the list of neighbours, and what the layout needs to
// evaluate it; a node 24 in the network (position), 144 for two states, and 8 for its mass.
double promised(const Network& net) {
  constexpr double a_spring = 64.0, a_node = 200.0;
  constexpr double rest = 3e6;  // stacks of threads, pages of plugins
  return a_spring * static_cast<double>(net.springs().size()) + a_node * static_cast<double>(net.nodes().size()) + rest;
}

Lattice box(std::uint32_t side) { return {{side, side, side}, Vector3::Ones(), Vector3::Zero(), Diagonals::space}; }

// The same springs, of which no two have one rest length.
void add_irregular(Network& net, std::uint32_t side, MaterialIndex material) {
  Network regular;
  regular.add_lattice("box", box(side), {}, regular.add_material(net.materials()[material]));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> off(-0.1, 0.1);
  net.reserve_nodes(regular.nodes().size());
  net.reserve_springs(regular.springs().size());
  for (Node node : regular.nodes()) {
    for (double& coordinate : node.position) coordinate += off(random);
    net.add_node(node);
  }
  for (const auto& [first, second] : regular.springs().ends()) net.add_spring(first, second, material);
}

template <class Add>
void check_footprint(const Add& add) {
  const std::optional<double> before = status("VmRSS");
  if (!before || !forget_peak()) {
    MESSAGE("this system does not tell how much memory a process takes");
    return;
  }
  const auto shared = std::make_shared<Network>();  // given by reference, the simulation would keep a copy
  Network& net = *shared;
  net.set_gravity({0, 0, -1});
  add(net, net.add_material(testing::damped(10.0, 0.1)));
  SimulationOptions options;
  options.integrator = {"recurrent", {{"update", 0.0}, {"sweeps", 1.0}}};
  options.time_step = 1e-3;
  options.threads = 2;
  Simulation simulation(std::shared_ptr<const Network>(shared), testing::plugins(), options);
  for (int step = 0; step < 3; ++step) simulation.step();
  const double stepping = status("VmRSS").value() - *before, peak = status("VmHWM").value() - *before;
  const auto springs = static_cast<double>(net.springs().size()), nodes = static_cast<double>(net.nodes().size());
  CAPTURE(stepping / springs);
  CAPTURE((stepping - 200.0 * nodes) / springs);
  CAPTURE((peak - 300.0 * nodes) / springs);
  CHECK(stepping <= promised(net));
  CHECK(peak <= 1.5 * promised(net));
  CHECK(stepping > 0.5 * promised(net));  // or what is measured is not what it takes
}

}  // namespace

TEST_CASE("a lattice of springs of one material takes what is promised") {
  check_footprint([](Network& net, MaterialIndex material) { net.add_lattice("box", box(60), {}, material); });
}

TEST_CASE("so does a net whose springs all have other rest lengths") {
  check_footprint([](Network& net, MaterialIndex material) { add_irregular(net, 60, material); });
}
