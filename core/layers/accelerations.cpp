// What the neurons of nodes answer to the forces on them.

#include <fmt/format.h>

#include <algorithm>

#include "layers/evaluator.hpp"
#include "plugin_host/call.hpp"
#include "plugin_host/message.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {

springnet_status Evaluator::accelerations(std::uint32_t first, std::uint32_t count, double time,
                                          const NodeArrays& nodes, const double* const force[3],
                                          double* const acceleration[3], double* by_force, double* by_position,
                                          double* by_velocity, const NeuronScalars& scalars,
                                          springnet_message& message) const {
  const std::vector<std::uint32_t>& kinds = layout_.neuron_kind();
  const bool one_kind = layout_.laws().neurons.size() == 1;
  for (std::uint32_t begin = 0; begin < count;) {
    const std::uint32_t node = first + begin;
    std::uint32_t end = one_kind ? count : begin + 1;
    while (end < count && kinds[first + end] == kinds[node]) ++end;
    const NeuronKind& kind = layout_.laws().neurons[kinds[node]];
    springnet_neuron_batch batch{};
    batch.count = end - begin;
    batch.time = time;
    batch.force = {force[0] + begin, force[1] + begin, force[2] + begin};
    batch.position = {nodes.px + node, nodes.py + node, nodes.pz + node};
    batch.velocity = {nodes.vx + node, nodes.vy + node, nodes.vz + node};
    batch.mass = mass_.data() + node;
    batch.acceleration = {acceleration[0] + begin, acceleration[1] + begin, acceleration[2] + begin};
    const auto block = [begin](double* blocks) { return blocks == nullptr ? nullptr : blocks + 9 * begin; };
    batch.acceleration_by_force = block(by_force);
    batch.acceleration_by_position = block(by_position);
    batch.acceleration_by_velocity = block(by_velocity);
    const auto vectors = [begin](double* values) { return values == nullptr ? nullptr : values + 3 * begin; };
    batch.acceleration_by_mass = vectors(scalars.by_mass);
    batch.acceleration_by_time = vectors(scalars.by_time);
    double* by_parameters[max_parameters];
    if (scalars.by_parameters != nullptr) {
      std::transform(scalars.by_parameters, scalars.by_parameters + kind.parameters.size(), by_parameters, vectors);
      batch.acceleration_by_parameters = by_parameters;
    }
    if (const springnet_status status = call_neuron(kind, batch, node, message); status != SPRINGNET_OK) return status;
    begin = end;
  }
  return SPRINGNET_OK;
}

springnet_status Evaluator::accelerations(std::span<const std::uint32_t> list, const ListedNodes& own, double time,
                                          const double* const force[3], double* const acceleration[3],
                                          springnet_message& message) const {
  const std::vector<std::uint32_t>& kinds = layout_.neuron_kind();
  const bool one_kind = layout_.laws().neurons.size() == 1;
  for (std::size_t begin = 0; begin < list.size();) {
    std::size_t end = one_kind ? list.size() : begin + 1;
    while (end < list.size() && kinds[list[end]] == kinds[list[begin]]) ++end;
    springnet_neuron_batch batch{};
    batch.count = static_cast<std::uint32_t>(end - begin);
    batch.time = time;
    batch.force = {force[0] + begin, force[1] + begin, force[2] + begin};
    batch.position = {own.p[0] + begin, own.p[1] + begin, own.p[2] + begin};
    batch.velocity = {own.v[0] + begin, own.v[1] + begin, own.v[2] + begin};
    batch.mass = own.mass + begin;
    batch.acceleration = {acceleration[0] + begin, acceleration[1] + begin, acceleration[2] + begin};
    const NeuronKind& kind = layout_.laws().neurons[kinds[list[begin]]];
    if (const springnet_status status = call_neuron(kind, batch, list[begin], message); status != SPRINGNET_OK)
      return status;
    begin = end;
  }
  return SPRINGNET_OK;
}

// Fills in the rest of a batch whose first node is `node`.
springnet_status Evaluator::call_neuron(const NeuronKind& kind, springnet_neuron_batch& batch, std::uint32_t node,
                                        springnet_message& message) const {
  const double* parameters[max_parameters];
  static constexpr std::uint32_t strides[max_parameters] = {};
  for (std::size_t p = 0; p < kind.parameters.size(); ++p) parameters[p] = &kind.parameters[p];
  batch.struct_size = sizeof batch;
  batch.instruction_set = abi_number(set_);
  batch.parameters = parameters;
  batch.parameter_strides = strides;
  const profile::Part part(kind.component->description->id, profile::Kind::neuron);
  const springnet_status status =
      call_component(*kind.component, message,
                     [&](springnet_message& own) {
                       batch.message = &own;
                       const springnet_neuron_model& model = kind.component->neuron();
                       return model.evaluate(model.context, &batch);
                     },
                     {CalledMembers::Are::nodes_from, 1, 1, layout_.ordering().user.data() + node});
  if (status == SPRINGNET_OK) return status;
  const std::uint32_t others = batch.count - 1;
  set_message(message, fmt::format("{}; for node {}{}", text_of(message), layout_.ordering().user[node],
                                   others == 0 ? "" : fmt::format(" or one of the {} after it", others)));
  return status;
}

}  // namespace springnet::layers
