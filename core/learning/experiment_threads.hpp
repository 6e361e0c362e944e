// How the threads of a search are shared among its experiments.
#pragma once

#include <vector>

#include <springnet/learn.hpp>

namespace springnet::learning {

// Experiments at a time, from so many threads; 0: as many as the machine has. One where a law or neuron may be called
// in the program's own thread alone.
[[nodiscard]] unsigned experiments_at_a_time(const std::vector<Experiment>& experiments, const PluginHost& plugins,
                                             unsigned threads);
// Options of a simulation that leave the number of its threads open, with its share of them.
[[nodiscard]] SimulationOptions with_share_of_threads(const Experiment& experiment, unsigned threads,
                                                      unsigned at_a_time);

}  // namespace springnet::learning
