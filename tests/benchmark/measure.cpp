#include "measure.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <springnet/error.hpp>

#include "clock.hpp"
#include "layers/instruction_set.hpp"
#include "naive_net.hpp"
#include "nets.hpp"
#include "simulation/model.hpp"

namespace springnet::benchmark {
namespace {

// The timed steps of a simulation, each with the fastest of its repetitions.
class TimedSteps {
 public:
  TimedSteps(const Case& one, const SimulationOptions& options, const Window& window, Clock clock)
      : case_(one), options_(options), window_(window), clock_(clock) {}

  // From the start.
  void repeat() {
    Simulation simulation(case_.network, testing::plugins(), options_);
    cost_ = {};
    try {
      for (std::uint64_t step = 0; step < window_.skipped; ++step) simulation.step();
      const double before = iterations_of(simulation);
      for (std::size_t step = 0; step < window_.steps && !has_ended(simulation); ++step) {
        const double start = now(clock_);
        cost_.sweeps += simulation.step().sweeps;
        const double time = now(clock_) - start;
        if (step == fastest_.size()) fastest_.push_back(time);
        fastest_[step] = std::min(fastest_[step], time);
        ++cost_.steps;
      }
      cost_.krylov_iterations = iterations_of(simulation) - before;
    } catch (const Error& error) {
      cost_.failure = error.what();
    }
  }

  [[nodiscard]] Cost cost() const {
    Cost cost = cost_;
    for (const double time : fastest_) cost.seconds += time;
    return cost;
  }

 private:
  [[nodiscard]] bool has_ended(const Simulation& simulation) const {
    return window_.steps == all_steps && simulation.time() > case_.duration - 0.5 * options_.time_step;
  }

  static double iterations_of(const Simulation& simulation) {
    const auto found = simulation.statistics().find("krylov_iterations");
    return found == simulation.statistics().end() ? 0.0 : found->second;
  }

  const Case& case_;
  const SimulationOptions& options_;
  const Window& window_;
  const Clock clock_;
  Cost cost_;
  std::vector<double> fastest_;  // [step] s
};

// The fastest time of a naive step. So short that nothing moves: a step costs the same in every state, and no net needs
// a step of its own to be stable.
class TimedNaiveSteps {
 public:
  explicit TimedNaiveSteps(const Case& one)
      : model_(stirred(one.network), *testing::plugins(), one.options), net_(stirred(one.network), model_.layout) {}

  void repeat() {
    const layers::FlushDenormals flush;
    constexpr double batch = 0.01, all = 0.06;  // s
    constexpr int fewest = 8;                   // batches
    std::size_t count = 1;
    double spent = 0.0;
    for (int done = 0; spent < all || done < fewest; ++done) {
      const double start = now(Clock::thread);
      for (std::size_t step = 0; step < count; ++step) net_.step(time_step);
      const double time = now(Clock::thread) - start;
      fastest_ = std::min(fastest_, time / static_cast<double>(count));
      spent += time;
      if (time < batch) count = 2 * count;
    }
  }

  [[nodiscard]] double fastest() const noexcept { return fastest_; }

 private:
  static constexpr double time_step = 1e-12;  // s

  // Nodes at rest would make a naive step a multiplication with zero.
  static Network stirred(Network net) {
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
      Node node = net.nodes()[k];
      if (node.fixed) continue;
      node.velocity += 1e-3 * Vector3(std::sin(1.0 + k), std::sin(2.0 + 3.0 * k), std::sin(3.0 + 7.0 * k));
      net.set_node(k, node);
    }
    return net;
  }

  Model model_;
  PlainNet net_;
  double fastest_ = std::numeric_limits<double>::infinity();
};

// Whether there is time for another repetition.
class Repetitions {
 public:
  explicit Repetitions(const Window& window) : window_(window), start_(now(Clock::wall)) {}

  bool next() {
    const double spent = now(Clock::wall) - start_;
    const double limit = done_ == 1 ? window_.most : done_ == 2 ? window_.enough : window_.least;
    if (done_ > 0 && spent >= limit) return false;
    ++done_;
    return true;
  }

 private:
  const Window& window_;
  double start_;
  int done_ = 0;
};

}  // namespace

Comparison against_naive(const Case& one, const Window& window) {
  TimedNaiveSteps naive(one);
  TimedSteps engine(one, one.options, window, Clock::thread);
  for (Repetitions repetitions(window); repetitions.next();) {
    naive.repeat();
    engine.repeat();
    if (!engine.cost().failure.empty()) break;
  }
  naive.repeat();
  return {engine.cost(), naive.fastest()};
}

Pair in_turn(const Case& one, const SimulationOptions& first, const SimulationOptions& second, const Window& window) {
  const Clock clock = first.threads == 1 && second.threads == 1 ? Clock::thread : Clock::wall;
  TimedSteps a(one, first, window, clock), b(one, second, window, clock);
  for (Repetitions repetitions(window); repetitions.next();) {
    a.repeat();
    b.repeat();
    if (!a.cost().failure.empty() || !b.cost().failure.empty()) break;
  }
  return {a.cost(), b.cost()};
}

}  // namespace springnet::benchmark
