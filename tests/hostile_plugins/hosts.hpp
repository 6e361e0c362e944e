// A simulation with hostile plugins, and what must hold whatever they do.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>

#include <springnet/sdk/plugin.h>
#include <springnet/error.hpp>
#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

namespace springnet::testing {

struct Expectation {
  bool fails = false;             // the run must end with an error
  std::optional<ErrorKind> kind;  // of this kind
  std::string names;              // that names this
};

// Runs a few steps and calls every query of the simulation. Returns what is wrong: an error without a message, with
// control characters or without the name; numbers in the state that are not finite; a step that is reported as done but
// is not.
std::string run_with(const springnet_plugin& plugin, const Network& network, const SimulationOptions& options,
                     const Expectation& expected);

// A few nodes in a row, the last one moving; or, `large`, as many as two threads share.
Network row(const Material& material, const LawUse& neuron, bool large = false);

// All cases of a long list, or a sample in the suite.
inline bool is_chosen(std::size_t number) {
  static const bool all = std::getenv("SPRINGNET_HOSTILE_PLUGINS") != nullptr;
  constexpr std::size_t one_in = 41;
  return all || number % one_in == 0;
}

}  // namespace springnet::testing
