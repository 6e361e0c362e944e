// The gradient of a motion by all of its rest lengths against the motion itself: time of both, alternately. The motion
// itself is a plain run of the simulation, from its construction on: it keeps no states. Beside it a plain run whose
// springs have values of their own, as those that are learned have, where the scene's may have them in common.
#include <cmath>
#include <ctime>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include <springnet/motion_derivatives.hpp>
#include <springnet/scene.hpp>

namespace {

using namespace springnet;

struct Motion {
  std::shared_ptr<const Network> network;
  SimulationOptions options;
  double duration;  // s
};

std::shared_ptr<const PluginHost> plugins() {
  static const auto host = std::make_shared<const PluginHost>(PluginHost::with_default_search());
  return host;
}

Motion of_scene(const std::string& folder, const std::string& name, double duration) {
  Scene scene = load_scene(EXAMPLES "/" + folder + "/" + name + ".toml", *plugins());
  scene.options.threads = 1;
  return {std::make_shared<const Network>(std::move(scene.network)), scene.options, duration};
}

// A block of 16 nodes a side that hangs from one of its faces, in steps far beyond explicit ones.
Motion lattice() {
  Network network;
  const auto material =
      network.add_material({LawUse{"linear", {{"stiffness", 2e4}}}, LawUse{"linear", {{"damping", 1.0}}}});
  network.add_lattice("lattice", {{16, 16, 16}, Vector3::Ones(), Vector3::Zero(), Diagonals::face}, {}, material);
  for (NodeIndex k = 0; k < 256; ++k) network.fix(16 * k);
  network.set_gravity({0, 0, -10});
  SimulationOptions options;
  options.integrator = {"recurrent", {{"theta", 0.5}}};
  options.time_step = 0.02;
  options.threads = 1;
  return {std::make_shared<const Network>(std::move(network)), options, 0.4};
}

// Of the processor, on one thread: other programs that run beside do not count.
double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Of linear systems: gradients then have less than five times this error, which is measured.
constexpr double accuracy = 2e-7, exact = 1e-12;
// As a search that ends at a tolerance of 1e-3 has it.
constexpr double accuracy_of_search = 1e-4;

// Of the height of all nodes after every fifth step.
Eigen::VectorXd gradient_of(MotionDerivatives& derivatives) {
  return derivatives.adjoint([](std::size_t k, MotionDerivatives::StateChange& add) {
    if (k % 5 == 0) add.positions.row(2).setOnes();
  });
}

// share: of the memory that all states would take; 1: 1 GiB.
void measure(benchmark::State& state, const Motion& motion, double share = 1.0) {
  std::vector<std::uint32_t> all(motion.network->springs().size());
  std::iota(all.begin(), all.end(), 0U);
  MotionDerivatives derivatives(motion.network, plugins(), motion.options, motion.duration,
                                {{LearnedValues::Kind::rest_length, false, "", all}});
  const double states = motion.duration / motion.options.time_step;
  if (share < 1.0)
    derivatives.set_memory(
        static_cast<std::size_t>(share * states * 48.0 * static_cast<double>(motion.network->nodes().size())));
  const Eigen::VectorXd values = derivatives.values_of_network();
  derivatives.run(values);
  derivatives.set_accuracy(exact);
  const Eigen::VectorXd right = gradient_of(derivatives);
  derivatives.set_accuracy(accuracy);
  Eigen::VectorXd gradient;
  double forward = 0.0, own_forward = 0.0, run = 0.0, both = 0.0;
  for (auto _ : state) {
    Simulation with_own(motion.network, plugins(), motion.options);
    with_own.set_rest_lengths(all, {values.begin(), values.end()});
    const double begun = seconds();
    with_own.advance_to(motion.duration);
    own_forward += seconds() - begun;
    const double start = seconds();
    Simulation simulation(motion.network, plugins(), motion.options);
    const double ready = seconds();
    simulation.advance_to(motion.duration);
    const double simulated = seconds();
    derivatives.run(values);
    const double ran = seconds();
    gradient = gradient_of(derivatives);
    const double done = seconds();
    forward += simulated - ready;
    run += ran - simulated;
    both += done - simulated;
    state.SetIterationTime(done - start);
  }
  state.counters["gradient_error"] = (gradient - right).norm() / right.norm();
  state.counters["values"] = static_cast<double>(all.size());
  state.counters["forward_ms"] = 1e3 * forward / static_cast<double>(state.iterations());
  state.counters["run_over_forward"] = run / forward;
  state.counters["with_gradient_over_forward"] = both / forward;
  state.counters["own_values_over_forward"] = own_forward / forward;
  state.counters["with_gradient_over_own_values"] = both / own_forward;
  const MotionDerivatives::Kept kept = derivatives.kept();
  state.counters["states"] = static_cast<double>(kept.states);
  state.counters["saved_states"] = static_cast<double>(kept.saved);
  state.counters["steps_again_over_steps"] =
      static_cast<double>(kept.steps_again) / static_cast<double>(derivatives.step_count());
}

// The twin of examples/twin: by the stiffness and the damping of each spring of the toy, in the motion of 100 frames
// that cameras saw. As the real toy's, stiffnesses differ from place to place by a factor of three at one standard
// deviation.
void gradient_twin(benchmark::State& state) {
  constexpr double median = 13.5, damping = 0.02, correlation = 0.052;  // N/m, N s/m, m
  constexpr int waves = 24;
  constexpr NodeIndex nodes_of_toy = 2000;
  const Motion motion = of_scene("twin", "toy", 3.3);
  std::vector<std::uint32_t> members;
  std::vector<double> values;
  for (std::uint32_t s = 0; s < motion.network->springs().size(); ++s) {
    const Spring spring = motion.network->springs()[s];
    if (spring.first >= nodes_of_toy || spring.second >= nodes_of_toy) continue;
    const auto place = [&](NodeIndex node) { return motion.network->nodes()[node].position; };
    const Vector3 middle = 0.5 * (place(spring.first) + place(spring.second));
    double field = 0.0;
    for (int i = 0; i < waves; ++i) {
      const Vector3 wave(std::cos(1.3 * i), std::cos(2.1 * i + 1.0), std::cos(0.7 * i + 2.0));
      field += std::cos(std::sqrt(2.0) / correlation * wave.dot(middle) + 2.4 * i);
    }
    members.push_back(s);
    values.push_back(median * std::pow(3.0, field / std::sqrt(0.5 * waves)));
  }
  values.resize(2 * values.size(), damping);
  using Kind = LearnedValues::Kind;
  MotionDerivatives derivatives(
      motion.network, plugins(), motion.options, motion.duration,
      {{Kind::spring_parameter, false, "stiffness", members}, {Kind::viscosity_parameter, false, "damping", members}});
  const Eigen::Map<const Eigen::VectorXd> all(values.data(), static_cast<Eigen::Index>(values.size()));
  derivatives.run(all);
  derivatives.set_accuracy(exact);
  const Eigen::VectorXd right = gradient_of(derivatives);
  derivatives.set_accuracy(accuracy_of_search);
  Eigen::VectorXd gradient;
  double run = 0.0, backwards = 0.0;
  for (auto _ : state) {
    const double start = seconds();
    derivatives.run(all);
    const double ran = seconds();
    gradient = gradient_of(derivatives);
    run += ran - start;
    backwards += seconds() - ran;
    state.SetIterationTime(seconds() - start);
  }
  state.counters["gradient_error"] = (gradient - right).norm() / right.norm();
  state.counters["values"] = static_cast<double>(values.size());
  state.counters["run_ms"] = 1e3 * run / static_cast<double>(state.iterations());
  state.counters["backwards_ms"] = 1e3 * backwards / static_cast<double>(state.iterations());
}

void gradient_bladder(benchmark::State& state) { measure(state, of_scene("bladder", "bladder", 1.0)); }
void gradient_sheet(benchmark::State& state) { measure(state, of_scene("sheet", "sheet", 0.05)); }
void gradient_lattice(benchmark::State& state) { measure(state, lattice()); }
// Beyond the memory budget.
void gradient_bladder_in_a_fifth(benchmark::State& state) { measure(state, of_scene("bladder", "bladder", 16.0), 0.2); }
void gradient_bladder_in_a_tenth(benchmark::State& state) { measure(state, of_scene("bladder", "bladder", 16.0), 0.1); }

BENCHMARK(gradient_bladder)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(gradient_sheet)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(gradient_lattice)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(gradient_twin)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(gradient_bladder_in_a_fifth)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(gradient_bladder_in_a_tenth)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
