// A copy of a simulation against a new one of the same network: time, and memory that each takes.
#include <malloc.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include <springnet/simulation.hpp>

namespace {

using namespace springnet;

std::shared_ptr<const PluginHost> plugins() {
  static const auto host = std::make_shared<const PluginHost>(PluginHost::with_default_search());
  return host;
}

std::shared_ptr<const Network> lattice(std::int64_t nodes_a_side) {
  Network network;
  const auto side = static_cast<std::uint32_t>(nodes_a_side);
  const auto material = network.add_material(
      {LawUse{"linear", {{"stiffness", 100.0}}, {}, {}}, LawUse{"linear", {{"damping", 1.0}}, {}, {}}});
  network.add_lattice("lattice", {{side, side, side}, Vector3::Ones(), Vector3::Zero(), Diagonals::space}, {},
                      material);
  network.set_gravity({0, 0, -1});
  return std::make_shared<const Network>(std::move(network));
}

SimulationOptions options() {
  SimulationOptions options;
  options.integrator = {"recurrent", {{"sweeps", 1.0}}};
  options.time_step = 1e-3;
  options.threads = 1;
  return options;
}

// Bytes that the program has asked for.
double allocated() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

// make(): a simulation; what it takes after a step, too.
template <class Make>
void measure(benchmark::State& state, const Network& network, const Make& make) {
  double bytes = 0.0, stepped = 0.0;
  for (auto _ : state) {
    const double before = allocated();
    std::optional<Simulation> made(make());
    state.PauseTiming();
    bytes = allocated() - before;
    made->step();
    stepped = allocated() - before;
    made.reset();
    state.ResumeTiming();
  }
  const auto springs = static_cast<double>(network.springs().size());
  state.counters["springs"] = springs;
  state.counters["bytes_a_spring"] = bytes / springs;
  state.counters["after_a_step"] = stepped / springs;
}

void new_simulation(benchmark::State& state) {
  const std::shared_ptr<const Network> network = lattice(state.range(0));
  measure(state, *network, [&] { return Simulation(network, plugins(), options()); });
}

void clone(benchmark::State& state) {
  const std::shared_ptr<const Network> network = lattice(state.range(0));
  Simulation original(network, plugins(), options());
  original.step();
  measure(state, *network, [&] { return original.clone(); });
}

// The first cut of a copy has to part it from the others.
void first_cut_of_a_clone(benchmark::State& state) {
  const std::shared_ptr<const Network> network = lattice(state.range(0));
  Simulation original(network, plugins(), options());
  double bytes = 0.0;
  for (auto _ : state) {
    state.PauseTiming();
    std::optional<Simulation> copy(original.clone());
    const double before = allocated();
    state.ResumeTiming();
    copy->cut({0, 1, 2});
    state.PauseTiming();
    bytes = allocated() - before;
    copy.reset();
    state.ResumeTiming();
  }
  state.counters["bytes_a_spring"] = bytes / static_cast<double>(network->springs().size());
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  for (const int side : {4, 25, 53}) benchmark->Args({side, 0});
  benchmark->ArgNames({"nodes_a_side", "copy"})->Unit(benchmark::kMillisecond);
}

BENCHMARK(new_simulation)->Apply(sizes);
BENCHMARK(clone)->Apply(sizes);
BENCHMARK(first_cut_of_a_clone)->Apply(sizes);

}  // namespace
