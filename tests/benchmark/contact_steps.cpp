// An explicit step with and without contact of bodies that do not touch: a block of 97,336 nodes above which there is
// another one, and a sheet of 40,000 nodes in narrow folds. All nodes move by chance.
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <utility>

#include <benchmark/benchmark.h>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/simulation.hpp>

namespace {

using namespace springnet;

constexpr double mass = 1e-3, speed = 2e-3, spacing = 1e-2;  // kg, m/s, m

class Dice {
 public:
  Vector3 velocity() { return speed * Vector3(number(), number(), number()); }

 private:
  double number() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 11) * 0x1p-52 - 1.0;
  }
  std::uint64_t state_ = 1;
};

Network blocks() {
  Network net;
  const MaterialIndex material =
      net.add_material({LawUse{"linear", {{"stiffness", 1000.0}}}, LawUse{"linear", {{"damping", 0.02}}}});
  Node node;
  node.mass = mass;
  net.add_lattice("block", {{46, 46, 46}, Vector3::Constant(spacing), Vector3::Zero(), Diagonals::face}, node,
                  material);
  net.add_lattice("above", {{20, 20, 20}, Vector3::Constant(spacing), Vector3(0.1, 0.1, 0.46), Diagonals::face}, node,
                  material);
  for (const std::size_t body : {0u, 1u}) net.set_extent(body, 1e-3, 0.0);
  return net;
}

Network sheet() {
  constexpr int side = 200, column = 20;
  constexpr double opening = 3e-4;
  const double rise = std::sqrt(spacing * spacing - opening * opening);
  Network net;
  const MaterialIndex material =
      net.add_material({LawUse{"linear", {{"stiffness", 1000.0}}}, LawUse{"linear", {{"damping", 0.02}}}});
  net.begin_body("sheet");
  Node node;
  node.mass = mass;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const int place = i % (2 * column), height = place < column ? place : 2 * column - place;
      node.position = {i * opening, j * spacing, height * rise};
      net.add_node(node);
    }
  const auto at = [](int i, int j) { return static_cast<NodeIndex>(i + side * j); };
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      if (i + 1 < side) net.add_spring(at(i, j), at(i + 1, j), material);
      if (j + 1 < side) net.add_spring(at(i, j), at(i, j + 1), material);
      if (i + 1 == side || j + 1 == side) continue;
      net.add_spring(at(i, j), at(i + 1, j + 1), material);
      net.add_spring(at(i + 1, j), at(i, j + 1), material);
      net.add_face({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      net.add_face({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  net.end_body();
  net.set_extent(0, 2e-4, 0.0);
  return net;
}

void explicit_step(benchmark::State& state, Network (*make)()) {
  Network net = make();
  if (state.range(0) != 0) {
    BodyContact contact;
    contact.first.resize(net.nodes().size());
    std::iota(contact.first.begin(), contact.first.end(), 0u);
    net.add_contact(contact);
  }
  static const auto plugins = std::make_shared<const PluginHost>(PluginHost::with_default_search());
  SimulationOptions options;
  options.integrator = {"verlet", {}};
  options.time_step = 1e-4;
  options.threads = 1;
  const NodeIndex nodes = static_cast<NodeIndex>(net.nodes().size());
  Simulation simulation(std::make_shared<const Network>(std::move(net)), plugins, options);
  Dice dice;
  for (NodeIndex k = 0; k < nodes; ++k) simulation.set_velocity(k, dice.velocity());
  simulation.step();
  for ([[maybe_unused]] auto iteration : state) simulation.step();
  if (!simulation.body_touches().empty()) state.SkipWithError("bodies touch");
  state.counters["nodes"] = nodes;
}

BENCHMARK_CAPTURE(explicit_step, block, blocks)->ArgName("contact")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(explicit_step, sheet, sheet)->ArgName("contact")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
