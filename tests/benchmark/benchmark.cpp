// Speed of whole time steps, through the interface of host programs. items_per_second is spring updates per
// second: springs x steps for a step of one sweep, springs x sweeps (evaluations of all springs) for steps that
// iterate. Lattices have axial and space-diagonal springs with linear stiffness and axial damping.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <springnet/error.hpp>
#include <springnet/sdk/host.hpp>
#include <springnet/simulation.hpp>

// internal: there is no public way to evaluate without a step
#include "layers/instruction_set.hpp"
#include "layers/kernels.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"
#include "simulation/sweep.hpp"

namespace {

using springnet::LawUse;
using springnet::Vector3;

std::shared_ptr<const springnet::PluginHost> plugins() {
  static const auto host = std::make_shared<const springnet::PluginHost>(springnet::PluginHost::with_default_search());
  return host;
}

// SPRINGNET_CHOICE options are given by the index of the choice.
double choice(const char* integrator, const char* option, const char* name) {
  const auto component = plugins()->require(springnet::ComponentKind::integrator, integrator);
  const std::ptrdiff_t at = springnet::parameter_index(*component->description, option);
  return static_cast<double>(springnet::choice_index(*component->description->parameters[at], name));
}

// stiffness N/m, damping N s/m; masses of 1 kg, 1 m apart. Every node starts with a velocity of its own: a lattice at
// rest would time multiplications with zero.
springnet::Network lattice(std::uint32_t nodes_a_side, const LawUse& spring, const LawUse& viscosity) {
  springnet::Network network;
  const auto material = network.add_material({.spring = spring, .viscosity = viscosity});
  network.add_lattice("lattice",
                      {.nodes = {nodes_a_side, nodes_a_side, nodes_a_side},
                       .spacing = Vector3::Ones(),
                       .origin = Vector3::Zero(),
                       .diagonals = springnet::Diagonals::space},
                      {}, material);
  std::uint64_t random = 1;
  for (springnet::NodeIndex index = 0; index < network.nodes().size(); ++index) {
    springnet::Node node = network.nodes()[index];
    for (double& component : node.velocity) {
      random = random * 6364136223846793005U + 1442695040888963407U;
      component = 1e-2 * (static_cast<double>(random >> 11) * 0x1p-53 - 0.5);
    }
    network.set_node(index, node);
  }
  return network;
}

springnet::Network lattice(std::uint32_t nodes_a_side, double stiffness, double damping) {
  return lattice(nodes_a_side, {"linear", {{"stiffness", stiffness}}}, {"linear", {{"damping", damping}}});
}

// The cube of examples/cube: falls on a plane and is compressed.
springnet::Network cube() {
  springnet::Network network;
  const auto material = network.add_material(
      {.spring = LawUse{"linear", {{"stiffness", 3.0}}}, .viscosity = LawUse{"linear", {{"damping", 2.0}}}});
  network.add_lattice("cube",
                      {.nodes = {4, 4, 4},
                       .spacing = Vector3::Ones(),
                       .origin = {0.0, 0.0, 0.081},
                       .diagonals = springnet::Diagonals::space},
                      {}, material);
  network.set_gravity({0.0, 0.0, -0.2});
  network.add_plane({.name = "ground"});
  return network;
}

// Net forces of all nodes, of springs and loads, at a state that does not change.
void evaluation(benchmark::State& state) {
  const springnet::SimulationOptions options{.threads = static_cast<unsigned>(state.range(1))};
  springnet::Model model(lattice(static_cast<std::uint32_t>(state.range(0)), 100.0, 0.1), *plugins(), options);
  springnet::Sweep sweep(model);
  const springnet_state& at = model.state.view;
  springnet_evaluation request{};
  request.struct_size = sizeof request;
  request.position = springnet::read_only(at.position);
  request.velocity = springnet::read_only(at.velocity);
  for ([[maybe_unused]] auto iteration : state) {
    if (sweep.evaluate(request) != SPRINGNET_OK) state.SkipWithError(model.journal.message.text);
  }
  const auto springs = static_cast<std::int64_t>(model.layout.live_count());
  state.SetItemsProcessed(state.iterations() * springs);
  state.counters["springs"] = static_cast<double>(springs);
}
BENCHMARK(evaluation)
    ->ArgNames({"nodes_a_side", "threads"})
    ->ArgsProduct({{4, 32, 100}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);

// Net forces of a crumpled sheet that has hinges only; items_per_second counts hinges.
void hinges(benchmark::State& state) {
  constexpr int side = 21;  // nodes
  springnet::Network network;
  const auto material = network.add_material(
      {.spring = LawUse{"linear", {{"stiffness", 1.0}}}, .viscosity = LawUse{"linear", {{"damping", 0.1}}}});
  const auto at = [](int i, int j) { return static_cast<springnet::NodeIndex>(side * i + j); };
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      springnet::Node node;
      node.position = {i + 0.1 * ((7 * i + 3 * j) % 5), j + 0.1 * ((2 * i + 5 * j) % 7), 0.1 * ((3 * i + 4 * j) % 6)};
      node.velocity = {0.01 * (i % 3), 0.01 * (j % 4), 0.01 * ((i + j) % 5)};
      network.add_node(node);
    }
  }
  for (int i = 0; i + 1 < side; ++i)
    for (int j = 0; j + 1 < side; ++j)
      network.add_element(springnet::Invariant::dihedral, {at(i, j), at(i + 1, j + 1), at(i + 1, j), at(i, j + 1)},
                          material, 0.1);
  springnet::Model model(network, *plugins(), {.threads = 1});
  springnet::Sweep sweep(model);
  springnet_evaluation request{};
  request.struct_size = sizeof request;
  request.position = springnet::read_only(model.state.view.position);
  request.velocity = springnet::read_only(model.state.view.velocity);
  for ([[maybe_unused]] auto iteration : state) {
    if (sweep.evaluate(request) != SPRINGNET_OK) state.SkipWithError(model.journal.message.text);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(network.elements().size()));
}
BENCHMARK(hinges)->Name("hinges/nodes_a_side:21/threads:1")->Unit(benchmark::kMicrosecond);

// ---- changes while a simulation runs ----

// What is timed of a thousand springs, at random, of a million that get another stiffness: the change, the step after
// it, or a step with nothing changed. One synchronous sweep a step: the cheapest there is.
enum class Timed { change, step_after_change, step };
void changes(benchmark::State& state, Timed timed) {
  const springnet::SimulationOptions options{
      .time_step = 1e-4,
      .integrator = {"recurrent", {{"update", choice("recurrent", "update", "synchronous")}, {"sweeps", 1.0}}},
      .threads = 1};
  springnet::Simulation simulation(lattice(54, 100.0, 0.1), plugins(), options);
  std::uint64_t random = 1;
  std::vector<springnet::SpringIndex> springs(1000);
  std::vector<double> values(springs.size());
  simulation.step();
  for ([[maybe_unused]] auto iteration : state) {
    for (std::size_t i = 0; i < springs.size(); ++i) {
      random = random * 6364136223846793005U + 1442695040888963407U;
      springs[i] = static_cast<springnet::SpringIndex>((random >> 33) % simulation.spring_count());
      values[i] = 100.0 + static_cast<double>(random >> 54);
    }
    const auto begin = std::chrono::steady_clock::now();
    if (timed != Timed::step)
      simulation.set_parameter(springs, springnet::ComponentKind::spring_function, "stiffness", values);
    const auto changed = std::chrono::steady_clock::now();
    simulation.step();
    const auto end = std::chrono::steady_clock::now();
    const std::chrono::duration<double> taken = timed == Timed::change ? changed - begin : end - changed;
    state.SetIterationTime(taken.count());
  }
  state.counters["springs"] = static_cast<double>(simulation.spring_count());
}
BENCHMARK_CAPTURE(changes, of_1000_springs, Timed::change)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(changes, step_after_change, Timed::step_after_change)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(changes, step, Timed::step)->UseManualTime()->Unit(benchmark::kMillisecond);

// ---- derivatives, in units of the forces ----

// The shortest time of `calls` calls, s, of some hundred: what interrupts one only adds to the others.
template <int calls = 1, class Call>
double shortest(const Call& call) {
  double least = 1.0;
  for (int i = 0; i < 400; ++i) {
    const auto before = std::chrono::steady_clock::now();
    for (int k = 0; k < calls; ++k) call();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count());
  }
  return least;
}

// A law on arrays that stay in the cache, as the engine calls it: with one parameter for all, and rest lengths and
// states of each. Counters: forces and tangent, and the derivatives by all parameters, in units of the time of forces.
void law_derivatives(benchmark::State& state, const char* id, const springnet::ParameterValues& given) {
  constexpr std::uint32_t count = springnet::layers::max_segment;  // springs that the engine has in a call
  const auto component = plugins()->require(springnet::ComponentKind::spring_function, id);
  const springnet_component& description = *component->description;
  const springnet_law& law = component->law();
  std::uint64_t random = 1;
  const auto numbers = [&](double from, double to) {
    std::vector<double> result(count);
    for (double& value : result) {
      random = random * 6364136223846793005U + 1442695040888963407U;
      value = from + (to - from) * (static_cast<double>(random >> 11) * 0x1p-53);
    }
    return result;
  };
  const std::vector<double> q = numbers(0.9, 1.3), rate = numbers(-1.0, 1.0), reference = numbers(0.9, 1.1);
  std::vector<double> parameter(description.parameter_count);
  std::vector<const double*> parameters, states;
  std::vector<std::vector<double>> state_values, by_parameter;
  std::vector<double*> by_parameters;
  for (std::size_t i = 0; i < parameter.size(); ++i) {
    const auto found = given.find(description.parameters[i]->name);
    parameter[i] = found == given.end() ? description.parameters[i]->default_value : found->second;
    parameters.push_back(&parameter[i]);
    by_parameter.emplace_back(count);
  }
  for (std::vector<double>& each : by_parameter) by_parameters.push_back(each.data());
  for (std::size_t i = 0; i < law.state_count; ++i) state_values.push_back(numbers(0.0, 0.1));
  for (const std::vector<double>& each : state_values) states.push_back(each.data());
  const std::vector<std::uint32_t> strides(parameter.size(), 0);
  std::vector<double> force(count), by_q(count), by_rate(count);
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = count;
  batch.instruction_set =
      springnet::layers::abi_number(springnet::layers::choose_instruction_set(springnet::InstructionSet::best));
  batch.q = q.data();
  batch.rate = (description.capabilities & SPRINGNET_READS_RATE) != 0 ? rate.data() : nullptr;
  batch.reference = reference.data();
  batch.reference_stride = 1;
  batch.parameters = parameters.data();
  batch.parameter_strides = strides.data();
  batch.states = states.data();
  batch.force = force.data();
  const auto call = [&] {
    if (law.evaluate(law.context, &batch) != SPRINGNET_OK) state.SkipWithError("the law failed");
    benchmark::ClobberMemory();
  };
  const double forces = shortest<16>(call);
  batch.force_by_q = by_q.data();
  if (batch.rate != nullptr) batch.force_by_rate = by_rate.data();
  const double tangent = shortest<16>(call);
  batch.force = batch.force_by_q = batch.force_by_rate = nullptr;
  batch.force_by_parameters = by_parameters.data();
  const double gradients = shortest<16>(call);
  batch.force_by_parameters = nullptr;
  batch.force = force.data();
  for ([[maybe_unused]] auto iteration : state) call();
  state.SetItemsProcessed(state.iterations() * count);
  state.counters["forces_and_tangent_in_forces"] = tangent / forces;
  state.counters["all_parameters_in_forces"] = gradients / forces;
}
BENCHMARK_CAPTURE(law_derivatives, linear, "linear", {{"stiffness", 3.0}})->Unit(benchmark::kNanosecond);
BENCHMARK_CAPTURE(law_derivatives, nonlinear, "nonlinear", {{"stiffness", 3.0}, {"cubic", 2.0}, {"quintic", 1.0}})
    ->Unit(benchmark::kNanosecond);
BENCHMARK_CAPTURE(law_derivatives, exponential, "exponential", {{"stiffness", 3.0}})->Unit(benchmark::kNanosecond);
BENCHMARK_CAPTURE(law_derivatives, maxwell, "maxwell", {{"stiffness", 3.0}, {"relaxation_time", 0.2}})
    ->Unit(benchmark::kNanosecond);

// Of a net: the gradient by the stiffness and damping of every spring and all masses, a tangent along the same, and
// products with the transposed derivatives. Counters: in units of one evaluation of all forces.
void net_derivatives(benchmark::State& state) {
  const springnet::SimulationOptions options{.threads = 1};
  springnet::Engine engine(lattice(static_cast<std::uint32_t>(state.range(0)), 100.0, 0.1), *plugins(), options);
  const springnet_host table = springnet::make_host_table(engine);
  const springnet::sdk::Host host(table);
  host.begin_step(0.0, 1e-3);
  springnet_evaluation at = springnet::sdk::evaluation_at(0.0, host.committed().state);
  const std::size_t n = host.network().node_count, springs = host.network().spring_number_count;
  std::vector<double> stiffness(springs), damping(springs), mass(n), weights(3 * n, 1.0), out(9 * n);
  const springnet::sdk::Host::ParameterSet sets[] = {{SPRINGNET_BY_SPRING_PARAMETER, stiffness, "stiffness"},
                                                     {SPRINGNET_BY_VISCOSITY_PARAMETER, damping, "damping"},
                                                     {SPRINGNET_BY_MASS, mass}};
  springnet_evaluation with_forces = at;
  with_forces.force = {out.data(), out.data() + n, out.data() + 2 * n};
  const double forces = shortest([&] { host.evaluate(with_forces); });
  const double gradient = shortest([&] { host.parameter_cotangent(at, sets, {nullptr, weights.data()}); });
  const double tangent = shortest([&] { host.parameter_tangent(at, sets, {nullptr, out.data()}); });
  const double linearise = shortest([&] { host.linearise(at); });
  const double transposed =
      shortest([&] { host.jacobian_transposed_times(weights.data(), out.data(), out.data() + 3 * n); });
  for ([[maybe_unused]] auto iteration : state) host.evaluate(with_forces);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(springs));
  state.counters["gradient_in_forces"] = gradient / forces;
  state.counters["tangent_in_forces"] = tangent / forces;
  state.counters["linearise_in_forces"] = linearise / forces;
  state.counters["transposed_in_forces"] = transposed / forces;
}
BENCHMARK(net_derivatives)->ArgName("nodes_a_side")->Arg(4)->Arg(32)->Unit(benchmark::kMicrosecond);

// A step of one synchronous sweep: symplectic Euler. The network stays the same size and in motion for any number of
// steps (t_c^2 k/m = 0.01, far inside the stable range, and little damping), so every step costs as much as the first.
void single_sweep_of(benchmark::State& state, const springnet::Network& network, unsigned threads) {
  const springnet::SimulationOptions options{
      .time_step = 0.01,
      .integrator = {"recurrent", {{"update", choice("recurrent", "update", "synchronous")}, {"sweeps", 1.0}}},
      .threads = threads};
  springnet::Simulation simulation(network, plugins(), options);
  simulation.step();  // the first one touches memory for the first time
  for ([[maybe_unused]] auto iteration : state) simulation.step();
  const auto springs = static_cast<std::int64_t>(simulation.spring_count());
  state.SetItemsProcessed(state.iterations() * springs);
  state.counters["springs"] = static_cast<double>(springs);
}
void single_sweep(benchmark::State& state) {
  single_sweep_of(state, lattice(static_cast<std::uint32_t>(state.range(0)), 100.0, 0.1),
                  static_cast<unsigned>(state.range(1)));
}
BENCHMARK(single_sweep)
    ->ArgNames({"nodes_a_side", "threads"})
    ->ArgsProduct({{4, 32, 100}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);

springnet::SimulationOptions one_sweep() {
  return {.time_step = 0.01,
          .integrator = {"recurrent", {{"update", choice("recurrent", "update", "synchronous")}, {"sweeps", 1.0}}},
          .threads = 2};
}

// From nothing to the first step: the network, its layout, the first forces. items_per_second counts springs.
void set_up(benchmark::State& state) {
  std::int64_t springs = 0;
  for ([[maybe_unused]] auto iteration : state) {
    const springnet::Network network = lattice(static_cast<std::uint32_t>(state.range(0)), 100.0, 0.1);
    springnet::Simulation simulation(network, plugins(), one_sweep());
    simulation.step();
    springs = static_cast<std::int64_t>(simulation.spring_count());
  }
  state.SetItemsProcessed(state.iterations() * springs);
}
BENCHMARK(set_up)->ArgName("nodes_a_side")->Arg(32)->Arg(100)->UseRealTime()->Unit(benchmark::kMillisecond);

// A cut of a thousand springs all over the net, and the step after it: less than two steps of single_sweep.
void cut_and_step(benchmark::State& state) {
  springnet::Simulation simulation(lattice(static_cast<std::uint32_t>(state.range(0)), 100.0, 0.1), plugins(),
                                   one_sweep());
  simulation.step();
  const std::size_t springs = simulation.spring_count();
  std::uint64_t next = 0;
  std::vector<springnet::SpringIndex> cut(1000);
  for ([[maybe_unused]] auto iteration : state) {
    for (springnet::SpringIndex& spring : cut)
      spring = static_cast<springnet::SpringIndex>((next += 7919 * 101) % springs);
    simulation.cut(cut);
    simulation.step();
  }
}
BENCHMARK(cut_and_step)->ArgName("nodes_a_side")->Arg(100)->UseRealTime()->Unit(benchmark::kMillisecond);

// A step of springs that may break, of which none does: what asking all of them costs.
void may_break(benchmark::State& state) {
  const springnet::Network network =
      lattice(static_cast<std::uint32_t>(state.range(0)), {"rupturing", {{"stiffness", 100.0}, {"strength", 1e9}}},
              {"linear", {{"damping", 0.1}}});
  springnet::Simulation simulation(network, plugins(), one_sweep());
  simulation.step();
  for ([[maybe_unused]] auto iteration : state) simulation.step();
}
BENCHMARK(may_break)->ArgName("nodes_a_side")->Arg(32)->Arg(100)->UseRealTime()->Unit(benchmark::kMillisecond);

// Steps of a net that tears, some hundreds to thousands of springs in each, beside the same net with stronger springs.
void tearing(benchmark::State& state) {
  constexpr int steps = 200;
  const double strength = state.range(1) != 0 ? 5.0 : 1e9;
  springnet::Network network =
      lattice(static_cast<std::uint32_t>(state.range(0)), {"rupturing", {{"stiffness", 100.0}, {"strength", strength}}},
              {"linear", {{"damping", 0.1}}});
  for (springnet::NodeIndex index = 0; index < network.nodes().size(); ++index) {
    springnet::Node node = network.nodes()[index];
    const double x = node.position[0] / static_cast<double>(state.range(0));
    node.velocity[0] += 0.06 * node.position[0] * x;  // the further, the sooner
    network.set_node(index, node);
  }
  std::unique_ptr<springnet::Simulation> simulation;
  std::size_t torn = 0;
  int left = 0;
  for ([[maybe_unused]] auto iteration : state) {
    if (left == 0) {
      state.PauseTiming();
      if (simulation) torn += simulation->spring_count() - simulation->live_spring_count();
      simulation = std::make_unique<springnet::Simulation>(network, plugins(), one_sweep());
      simulation->step();
      left = steps;
      state.ResumeTiming();
    }
    simulation->step();
    --left;
  }
  torn += simulation->spring_count() - simulation->live_spring_count();
  state.counters["torn_per_step"] = static_cast<double>(torn) / static_cast<double>(state.iterations());
}
BENCHMARK(tearing)
    ->ArgNames({"nodes_a_side", "tears"})
    ->ArgsProduct({{32, 100}, {0, 1}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// The same with other laws, beside linear ones: functions, internal states, signals, tables.
const LawUse linear_spring{"linear", {{"stiffness", 100.0}}}, linear_damper{"linear", {{"damping", 0.1}}};
const struct {
  const char* name;
  LawUse spring, viscosity = linear_damper;
} other_laws[] = {
    {"linear", linear_spring},
    {"exponential", {"exponential", {{"stiffness", 100.0}, {"exponent", 3.0}}}},
    {"power", linear_spring, {"power", {{"damping", 0.1}, {"exponent", 1.7}}}},
    {"table", {"table", {}, {{"elongations", {-0.5, -0.1, 0.0, 0.1, 0.5}}, {"forces", {-60, -10, 0, 10, 60}}}}},
    {"muscle", {"muscle", {{"strength", 10.0}}}},
    {"maxwell", {"maxwell", {{"stiffness", 100.0}, {"relaxation_time", 0.1}}}},
    {"standard_linear_solid",
     {"standard_linear_solid", {{"stiffness", 50.0}, {"fast_stiffness", 50.0}, {"relaxation_time", 0.1}}}},
    {"plastic",
     {"plastic", {{"stiffness", 100.0}, {"yield_tension", 0.01}, {"hardening", 50.0}, {"relaxation_time", 0.1}}}},
    {"damaging",
     {"damaging",
      {{"stiffness", 100.0}, {"threshold_strain", 1e-4}, {"softening_strain", 10.0}, {"relaxation_time", 0.1}}}},
};

springnet::Network lattice_of(std::uint32_t nodes_a_side, const LawUse& spring, const LawUse& viscosity) {
  springnet::Network network = lattice(nodes_a_side, spring, viscosity);
  if (spring.id != "muscle") return network;
  springnet::Input activation;
  activation.input = "activation";
  for (springnet::SpringIndex k = 0; k < network.springs().size(); ++k) activation.springs.push_back(k);
  activation.signal.mean = activation.signal.amplitude = 0.1;
  activation.signal.frequency = 1.0;  // Hz
  network.add_input(activation);
  return network;
}

// Sweeps of Newton's method from one end of a step to the other; items_per_second counts sweeps of all springs.
void newton_of(benchmark::State& state, const springnet::Network& network) {
  const springnet::SimulationOptions options{
      .time_step = 0.01,
      .integrator = {"recurrent", {{"update", choice("recurrent", "update", "newton")}}},
      .threads = 1};
  springnet::Simulation simulation(network, plugins(), options);
  simulation.step();
  std::uint64_t sweeps = 0;
  for ([[maybe_unused]] auto iteration : state) sweeps += simulation.step().sweeps;
  state.SetItemsProcessed(static_cast<std::int64_t>(sweeps * simulation.spring_count()));
}

void register_laws() {
  for (const auto& law : other_laws) {
    const auto net = [&law](const benchmark::State& state) {
      return lattice_of(static_cast<std::uint32_t>(state.range(0)), law.spring, law.viscosity);
    };
    benchmark::RegisterBenchmark((std::string("laws/") + law.name).c_str(),
                                 [net](benchmark::State& state) { single_sweep_of(state, net(state), 1); })
        ->ArgName("nodes_a_side")
        ->Arg(4)
        ->Arg(32)
        ->UseRealTime();
    benchmark::RegisterBenchmark((std::string("newton/") + law.name).c_str(),
                                 [net](benchmark::State& state) { newton_of(state, net(state)); })
        ->ArgName("nodes_a_side")
        ->Arg(16)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
  }
}

// Repeats the first 5 s of the cube's fall (touch-down at 0.9 s, deepest at 3.95 s), one step per iteration.
void cube_steps(benchmark::State& state, const springnet::SimulationOptions& options) {
  const springnet::Network network = cube();
  auto simulation = std::make_unique<springnet::Simulation>(network, plugins(), options);
  std::uint64_t sweeps = 0;
  for ([[maybe_unused]] auto iteration : state) {
    sweeps += simulation->step().sweeps;
    if (simulation->time() > 5.0) {
      state.PauseTiming();
      simulation = std::make_unique<springnet::Simulation>(network, plugins(), options);
      state.ResumeTiming();
    }
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(sweeps * network.springs().size()));
  state.counters["sweeps_per_step"] =
      benchmark::Counter(static_cast<double>(sweeps), benchmark::Counter::kAvgIterations);
}

void cube_recurrent(benchmark::State& state, const char* update) {
  cube_steps(state, {.time_step = 0.05,
                     .integrator = {"recurrent", {{"update", choice("recurrent", "update", update)}}},
                     .threads = 1});
}
BENCHMARK_CAPTURE(cube_recurrent, synchronous, "synchronous")->Name("cube_synchronous/nodes_a_side:4/threads:1");
BENCHMARK_CAPTURE(cube_recurrent, wavefront, "wavefront")->Name("cube_wavefront/nodes_a_side:4/threads:1");
BENCHMARK_CAPTURE(cube_recurrent, block, "block")->Name("cube_block/nodes_a_side:4/threads:1");
BENCHMARK_CAPTURE(cube_recurrent, coloured, "coloured")->Name("cube_coloured/nodes_a_side:4/threads:1");

// Output points 0.05 s apart; inside, the method's own steps.
void cube_cvode(benchmark::State& state) {
  cube_steps(state, {.time_step = 0.05, .integrator = {"cvode", {}}, .threads = 1});
}
BENCHMARK(cube_cvode)->Name("cube_cvode/nodes_a_side:4/threads:1");

}  // namespace

// Errors of the library (a plugin that is missing) end the program with their message and status 1.
int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  try {
    register_laws();
    benchmark::RunSpecifiedBenchmarks();
  } catch (const springnet::Error& error) {
    benchmark::Shutdown();
    std::fprintf(stderr, "springnet_benchmark: %s\n", error.what());
    return 1;
  }
  benchmark::Shutdown();
}
