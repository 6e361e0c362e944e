#include "check/neuron_call.hpp"

#include <string.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include <springnet/printable.hpp>

#include "check/law_call.hpp"
#include "check/points.hpp"

namespace springnet::check {
namespace {

using namespace node_inputs;

constexpr double not_written = -1.234567890123e300;  // what outputs are filled with

bool has(const Component& component, std::uint64_t capability) {
  return (component.description->capabilities & capability) != 0;
}

}  // namespace

NeuronAnswer call_neuron(const Component& component, const std::vector<NodeInputs>& nodes, const NeuronHow& how) {
  const std::size_t count = nodes.size(), P = component.description->parameter_count;
  Memory memory(how.layout, how.offset);
  const auto input = [&](std::size_t which, bool one, const char* name) {
    std::vector<double> values;
    for (const NodeInputs& node : nodes) values.push_back(node[which]);
    if (one) values.resize(1);
    return memory.input(values, name);
  };
  const auto vectors = [&](std::size_t first, const char* name) {
    return springnet_const_vectors{input(first, false, name), input(first + 1, false, name),
                                   input(first + 2, false, name)};
  };
  std::vector<const double*> parameters;
  std::vector<std::uint32_t> strides;
  for (std::size_t j = 0; j < P; ++j) {
    const std::size_t which = parameter + j;
    const bool one = how.share && std::all_of(nodes.begin(), nodes.end(), [&](const NodeInputs& node) {
                       return same_bits(node[which], nodes[0][which]);
                     });
    parameters.push_back(input(which, one, component.description->parameters[j]->name));
    strides.push_back(one ? 0 : 1);
  }
  springnet_neuron_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = static_cast<std::uint32_t>(count);
  batch.instruction_set = how.instruction_set;
  batch.time = nodes[0][node_inputs::time];
  batch.force = vectors(force, "force");
  batch.position = vectors(position, "position");
  batch.velocity = vectors(velocity, "velocity");
  batch.mass = input(mass, false, "mass");
  batch.parameters = memory.input(parameters, "the list of parameters");
  batch.parameter_strides = memory.input(strides, "the strides of parameters");
  const auto output = [&](std::size_t numbers, const char* name) {
    return memory.output(numbers * count, name, not_written);
  };
  const std::array<double*, 3> acceleration{output(1, "acceleration"), output(1, "acceleration"),
                                            output(1, "acceleration")};
  batch.acceleration = {acceleration[0], acceleration[1], acceleration[2]};
  std::array<double*, 3> blocks{};
  double *by_mass = nullptr, *by_time = nullptr;
  std::vector<double*> by_parameters;
  if (how.derivatives && has(component, SPRINGNET_HAS_DERIVATIVES)) {
    blocks = {output(9, "acceleration_by_force"), output(9, "acceleration_by_position"),
              output(9, "acceleration_by_velocity")};
    batch.acceleration_by_force = blocks[0];
    batch.acceleration_by_position = blocks[1];
    batch.acceleration_by_velocity = blocks[2];
  }
  const bool more = how.derivatives && has(component, SPRINGNET_HAS_PARAMETER_DERIVATIVES);
  if (more) {
    by_mass = batch.acceleration_by_mass = output(3, "acceleration_by_mass");
    by_time = batch.acceleration_by_time = output(3, "acceleration_by_time");
    for (std::size_t j = 0; j < P; ++j) by_parameters.push_back(output(3, "acceleration_by_parameters"));
    batch.acceleration_by_parameters = memory.input(by_parameters, "the list acceleration_by_parameters");
  }
  springnet_message* const message = memory.output(1, "the message", springnet_message{});
  batch.message = message;
  const springnet_neuron_batch* const given = memory.input(std::vector<springnet_neuron_batch>{batch}, "the batch");
  memory.protect();
  const springnet_status status = component.neuron().evaluate(component.neuron().context, given);
  if (status != SPRINGNET_OK) {
    const std::string text = printable({message->text, strnlen(message->text, sizeof message->text)}, 300);
    throw std::runtime_error(fmt::format("it fails with the status {}{}{}", status, text.empty() ? "" : ": ", text));
  }

  NeuronAnswer answer;
  const auto require = [](double value, const char* name) {
    if (value == not_written) throw std::runtime_error(fmt::format("it leaves the {} unwritten", name));
    return value;
  };
  for (std::size_t i = 0; i < count; ++i)
    for (const double* axis : acceleration) answer.acceleration.push_back(require(axis[i], "acceleration"));
  if (blocks[0] != nullptr)
    for (const double* block : blocks)
      for (std::size_t j = 0; j < 3; ++j) {
        std::vector<double>& by = answer.by.emplace_back();
        for (std::size_t i = 0; i < count; ++i)
          for (std::size_t axis = 0; axis < 3; ++axis)
            by.push_back(require(block[9 * i + 3 * axis + j], "derivatives of the acceleration"));
      }
  if (blocks[0] != nullptr && more) {
    std::vector<const double*> others{by_mass, by_time};
    others.insert(others.end(), by_parameters.begin(), by_parameters.end());
    for (const double* each : others) {
      std::vector<double>& by = answer.by.emplace_back();
      for (std::size_t k = 0; k < 3 * count; ++k) by.push_back(require(each[k], "derivatives of the acceleration"));
    }
  }
  return answer;
}

std::string input_name(const Component& component, std::size_t which) {
  if (which < position) return "the force";
  if (which < velocity) return "the position";
  if (which < mass) return "the velocity";
  if (which == mass) return "the mass";
  if (which == node_inputs::time) return "the time";
  return fmt::format("parameter '{}'", component.description->parameters[which - parameter]->name);
}

NodeInputs any_node(const Component& component, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  NodeInputs at;
  for (std::size_t k = force; k < mass; ++k) at.push_back(unit(random));
  at.push_back(std::pow(3.0, unit(random)));
  at.push_back(1.0 + unit(random));
  const std::vector<double> typical = typical_parameters(*component.description);
  for (std::size_t j = 0; j < typical.size(); ++j) {
    const springnet_parameter& p = *component.description->parameters[j];
    const double value = typical[j] * std::pow(3.0, unit(random));
    at.push_back(p.type == SPRINGNET_NUMBER ? std::clamp(value, p.smallest, p.largest) : typical[j]);
  }
  return at;
}

}  // namespace springnet::check
