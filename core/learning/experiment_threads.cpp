#include "learning/experiment_threads.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "layers/evaluator.hpp"
#include "simulation/max_threads.hpp"

namespace springnet::learning {

namespace {

bool is_for_one_thread(const LawUse& use, ComponentKind kind, const PluginHost& plugins) {
  const std::shared_ptr<const Component> component = use.component ? use.component : plugins.require(kind, use.id);
  return (component->description->capabilities & SPRINGNET_CALLING_THREAD_ONLY) != 0;
}

bool is_for_one_thread(const Network& network, const PluginHost& plugins) {
  const auto any = [&](const std::optional<LawUse>& use, ComponentKind kind) {
    return use && is_for_one_thread(*use, kind, plugins);
  };
  return std::any_of(network.materials().begin(), network.materials().end(),
                     [&](const Material& each) {
                       return any(each.spring, ComponentKind::spring_function) ||
                              any(each.viscosity, ComponentKind::viscosity_function);
                     }) ||
         std::any_of(network.neurons().begin(), network.neurons().end(),
                     [&](const LawUse& each) { return is_for_one_thread(each, ComponentKind::neuron, plugins); });
}

unsigned threads_in_all(unsigned threads) {
  if (threads > max_threads)
    throw Error(ErrorKind::input, fmt::format("learning: threads must be 0 to {}, is {}; 0 takes as many as the "
                                              "machine has",
                                              max_threads, threads));
  return threads > 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
}

}  // namespace

unsigned experiments_at_a_time(const std::vector<Experiment>& experiments, const PluginHost& plugins,
                               unsigned threads) {
  const unsigned all = threads_in_all(threads);
  if (all == 1 || experiments.size() < 2) return 1;
  for (const Experiment& each : experiments)
    if (is_for_one_thread(*each.network, plugins)) return 1;
  return static_cast<unsigned>(std::min<std::size_t>(all, experiments.size()));
}

SimulationOptions with_share_of_threads(const Experiment& experiment, unsigned threads, unsigned at_a_time) {
  SimulationOptions options = experiment.options;
  if (options.threads != 0 || (threads == 0 && at_a_time == 1)) return options;
  const std::size_t size = experiment.network->springs().size() + experiment.network->elements().size();
  const bool is_worth_it = layers::useful_threads(0, size, size) > 1;
  options.threads = is_worth_it ? std::max(1u, threads_in_all(threads) / at_a_time) : 1;
  return options;
}

}  // namespace springnet::learning
