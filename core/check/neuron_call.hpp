// Calls of a neuron as a host makes them.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>

#include "check/memory.hpp"

namespace springnet::check {

// What a neuron reads of one node, in this order: force, position, velocity (3 each), mass, time, parameters.
using NodeInputs = std::vector<double>;
namespace node_inputs {
enum : std::size_t { force = 0, position = 3, velocity = 6, mass = 9, time = 10, parameter = 11 };
}

struct NeuronHow {
  std::uint32_t instruction_set = SPRINGNET_GENERIC;
  bool derivatives = false;  // all that the neuron declares
  bool share = false;        // parameters that are equal for all nodes have the stride 0
  Memory::Layout layout = Memory::Layout::roomy;
  std::size_t offset = 0;  // numbers by which arrays are off a multiple of 64 bytes
};

struct NeuronAnswer {
  std::vector<double> acceleration;     // [3 node + axis]
  std::vector<std::vector<double>> by;  // [input][3 node + axis], of those declared: up to the velocity, or all
};

// Throws std::runtime_error if the neuron fails. The time is that of the first node.
[[nodiscard]] NeuronAnswer call_neuron(const Component& component, const std::vector<NodeInputs>& nodes,
                                       const NeuronHow& how = {});
// "the force", "parameter 'drag'".
[[nodiscard]] std::string input_name(const Component& component, std::size_t input);
// Random, within the bounds of parameters.
[[nodiscard]] NodeInputs any_node(const Component& component, std::mt19937_64& random);

}  // namespace springnet::check
