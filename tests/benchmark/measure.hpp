// Times of the table of steps (steps_table.cpp): steps of the engine and naive steps of the same net, in turn.
#pragma once

#include <cstdint>
#include <string>

#include <springnet/simulation.hpp>

#include "table_nets.hpp"

namespace springnet::benchmark {

// Which steps are timed, and how often. A simulation makes the same steps each time, so that each counts with its
// fastest time: what other programs on the machine cost is left out as far as possible.
struct Window {
  std::uint64_t skipped = 0;  // steps from the start that are not timed
  std::uint64_t steps = 1;    // timed; all_steps: until the end of the scene
  // s: a row is repeated for `least`, up to `most` to be repeated once, and up to `enough` to be repeated twice. All 0:
  // once.
  double least = 2.0, enough = 10.0, most = 25.0;
};
inline constexpr std::uint64_t all_steps = ~std::uint64_t{0};

struct Cost {
  double seconds = 0.0;  // of all timed steps
  std::uint64_t steps = 0, sweeps = 0;
  double krylov_iterations = 0.0;
  std::string failure{};  // why a step failed; empty if none did
};

// Steps on one thread in seconds of that thread, and naive steps too; `naive` is the time of one.
struct Comparison {
  Cost engine;
  double naive = 0.0;  // s
};
[[nodiscard]] Comparison against_naive(const Case& one, const Window& window);

// The same steps in two ways: in seconds of the thread if both run on one, else in those of the clock.
struct Pair {
  Cost first, second;
};
[[nodiscard]] Pair in_turn(const Case& one, const SimulationOptions& first, const SimulationOptions& second,
                           const Window& window);

}  // namespace springnet::benchmark
