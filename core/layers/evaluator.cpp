#include "layers/evaluator.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <string>

#include "plugin_host/call.hpp"
#include "plugin_host/message.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

constexpr std::size_t springs_in_an_element = 4;  // by the time that its evaluation takes

}  // namespace

unsigned useful_threads(unsigned wanted, std::size_t springs, std::size_t units) {
  constexpr std::size_t springs_worth_a_thread = 8000;
  const auto machine = static_cast<unsigned>(std::max(1, omp_get_num_procs()));
  if (wanted == 0) {
    wanted = springs < springs_worth_a_thread ? 1 : machine;
  }
  return std::max(1u, std::min(wanted, static_cast<unsigned>(std::max<std::size_t>(1, units))));
}

Evaluator::Evaluator(const Layout& layout, const std::vector<double>& mass, InstructionSet set, unsigned threads)
    : layout_(layout),
      mass_(mass),
      set_(choose_instruction_set(set)),
      kernels_(kernels_for(set_)),
      threads_(useful_threads(threads, layout.spring_count() + springs_in_an_element * layout.elements().count(),
                              layout.units().size())) {
  const ElementLayout& elements = layout.elements();
  for (std::vector<double>& component : corner_force_) component.resize(max_corners * elements.batched().size());
  enclosure_force_.resize(elements.enclosures().size());
  for (std::uint32_t s = 0; s < elements.enclosures().size(); ++s) {
    const auto size = static_cast<std::uint32_t>(elements.enclosures()[s].shape.size());
    enclosure_gradient_.emplace_back(size, Vector3::Zero());
    for (std::uint32_t begin = 0; begin < size; begin += enclosure_chunk)
      chunks_.push_back({s, begin, std::min(size, begin + static_cast<std::uint32_t>(enclosure_chunk))});
  }
  enclosure_shares_.resize(chunks_.size());
}

springnet_status Evaluator::evaluate(double time, const NodeArrays& nodes, const ExternalForces& external,
                                     const ForceArrays& force, TileFinished finished,
                                     springnet_message& message) const {
  if (layout_.elements().live_count() > 0) {
    if (const springnet_status status = evaluate_elements(time, nodes, message); status != SPRINGNET_OK) return status;
  }
  const auto units = static_cast<std::int64_t>(layout_.units().size());
  if (threads_ == 1) {
    const FlushDenormals flush;
    for (std::int64_t u = 0; u < units; ++u) {
      const springnet_status status =
          evaluate_unit(static_cast<std::uint32_t>(u), time, nodes, external, force, finished, message);
      if (status != SPRINGNET_OK) return status;
    }
    return SPRINGNET_OK;
  }
  std::int64_t failed_unit = units;
  springnet_status failure = SPRINGNET_OK;
  const profile::Region region(threads_);
#pragma omp parallel num_threads(static_cast <int>(threads_))
  {
    const FlushDenormals flush;
    const profile::Share share(region, omp_get_thread_num(), omp_get_num_threads());
#pragma omp for schedule(dynamic, 1) nowait
    for (std::int64_t u = 0; u < units; ++u) {
      springnet_message unit_message{};
      // An exception that leaves the region would end the process.
      const springnet_status status = sdk::detail::guarded(&unit_message, [&] {
        return evaluate_unit(static_cast<std::uint32_t>(u), time, nodes, external, force, finished, unit_message);
      });
      if (status != SPRINGNET_OK) {
#pragma omp critical(springnet_evaluate)
        if (u < failed_unit) {
          failed_unit = u;
          failure = status;
          message = unit_message;
        }
      }
    }
  }
  return failure;
}

springnet_status Evaluator::evaluate_unit(std::uint32_t index, double time, const NodeArrays& nodes,
                                          const ExternalForces& external, const ForceArrays& force,
                                          TileFinished finished, springnet_message& message) const {
  const Unit& unit = layout_.units()[index];
  const double* mass = mass_.data();
  const std::uint32_t begin = unit.first_node, end = unit.first_node + unit.node_count;
  const Vector3 g = external.gravity;
  if (external.loads.x == nullptr) {
    for (std::uint32_t k = begin; k < end; ++k) {
      force.x[k] = mass[k] * g[0];
      force.y[k] = mass[k] * g[1];
      force.z[k] = mass[k] * g[2];
    }
  } else {
    for (std::uint32_t k = begin; k < end; ++k) {
      force.x[k] = mass[k] * g[0] + external.loads.x[k];
      force.y[k] = mass[k] * g[1] + external.loads.y[k];
      force.z[k] = mass[k] * g[2] + external.loads.z[k];
    }
  }
  if (external.pressure != nullptr && layout_.loaded_faces().any_following()) {
    for (std::uint32_t k = begin; k < end; ++k) {
      const Vector3 push = layout_.loaded_faces().force(k, nodes, external.pressure);
      force.x[k] += push[0];
      force.y[k] += push[1];
      force.z[k] += push[2];
    }
  }
  if (layout_.elements().live_count() > 0) {
    const profile::Tile measured;
    const profile::Part part("elements");
    add_elements(begin, end, force);
  }
  SegmentGeometry geometry;  // not initialised: written before it is read
  for (const Tile& tile : unit.tiles) {
    const profile::Tile measured;
    {
      const profile::Part part("springs");
      for (std::uint32_t s = tile.segment_begin; s < tile.segment_end; ++s) {
        const springnet_status status = evaluate_segment(unit, unit.segments[s], time, nodes, force, geometry, message);
        if (status != SPRINGNET_OK) return status;
      }
    }
    if (finished.call == nullptr) continue;
    const springnet_status status = finished.call(finished.user, index, tile.first_node, tile.node_count, message);
    if (status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

springnet_status Evaluator::accelerations(std::uint32_t first, std::uint32_t count, double time,
                                          const NodeArrays& nodes, const double* const force[3],
                                          double* const acceleration[3], double* by_force, double* by_position,
                                          double* by_velocity, springnet_message& message) const {
  const std::vector<std::uint32_t>& kinds = layout_.neuron_kind();
  for (std::uint32_t begin = 0; begin < count;) {
    const std::uint32_t node = first + begin;
    std::uint32_t end = begin + 1;
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
  const springnet_status status = call_component(*kind.component, message, [&](springnet_message& own) {
    batch.message = &own;
    return kind.component->neuron().evaluate(&batch);
  });
  if (status == SPRINGNET_OK) return status;
  const std::uint32_t others = batch.count - 1;
  set_message(message, fmt::format("{}; for node {}{}", text_of(message), layout_.ordering().user[node],
                                   others == 0 ? "" : fmt::format(" or one of the {} after it", others)));
  return status;
}

}  // namespace springnet::layers
