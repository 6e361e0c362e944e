// Nets to learn, and observations of them.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include <springnet/learn.hpp>

#include "generator.hpp"
#include "nets.hpp"

namespace springnet::testing {

inline std::vector<std::uint32_t> from_to(std::size_t first, std::size_t last) {
  std::vector<std::uint32_t> result;
  for (std::size_t k = first; k < last; ++k) result.push_back(static_cast<std::uint32_t>(k));
  return result;
}

// Steps that have settled to rounding.
inline SimulationOptions to_learn_with(double theta, double step) {
  SimulationOptions options;
  options.integrator = recurrent(newton, 1e-12, {{"theta", theta}});
  options.time_step = step;
  options.threads = 1;
  return options;
}

// Normal, of deviation 1, as good as twelve uniform numbers make it.
inline Vector3 normal(Dice& dice) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < 12; ++i) sum += dice.in_box(0.5);
  return sum;
}

inline Observations::VectorRow row(double time, NodeIndex node, const Vector3& value) {
  Observations::VectorRow result;
  result.time = time;
  result.node = node;
  result.value = value;
  result.weight = Vector3::Ones();
  return result;
}

// Positions of nodes after each step, with noise of this deviation, m.
inline Observations observe(Simulation& simulation, int steps, const std::vector<std::uint32_t>& nodes,
                            double noise = 0.0, std::uint64_t seed = 1) {
  Observations result;
  Dice dice(seed);
  for (int i = 0; i < steps; ++i) {
    simulation.step();
    for (const NodeIndex k : nodes)
      result.positions.push_back(row(simulation.time(), k, simulation.position(k) + noise * normal(dice)));
  }
  return result;
}

inline Experiment experiment(const Network& network, const SimulationOptions& options, Observations observations) {
  return {std::make_shared<const Network>(network), options, std::move(observations)};
}

}  // namespace springnet::testing
