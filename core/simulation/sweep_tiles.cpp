#include "simulation/sweep_tiles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include <springnet/sdk/message.hpp>

#include "constraints/vectors.hpp"
#include "profile/stage.hpp"

namespace springnet {
namespace {

// Calls the integrator's update, which must not throw; if it does, the sweep ends with a message.
springnet_status call_update(const springnet_sweep& sweep, const springnet_node_batch& batch,
                             springnet_message& message) noexcept {
  const profile::Part part("update");
  try {
    const springnet_status status = sweep.update(sweep.user, &batch);
    if (status != SPRINGNET_OK) sdk::detail::write_message(&message, "the integrator's update of nodes failed");
    return status;
  } catch (const std::exception& error) {
    char text[2 * sizeof message.text];
    std::snprintf(text, sizeof text, "the integrator's update of nodes threw an exception: %s", error.what());
    sdk::detail::write_message(&message, text);
  } catch (...) {
    sdk::detail::write_message(&message,
                               "the integrator's update of nodes threw something that is not a std::exception");
  }
  return SPRINGNET_FAILED;
}

}  // namespace

bool Sweep::Tiles::all_finite(const double* const values[3], std::uint32_t count) const noexcept {
  return model.evaluator.all_finite(values, count);
}

void Sweep::Tiles::note_bad_neuron(std::uint32_t first, std::uint32_t count, const double* const acceleration_of[3]) {
  for (std::uint32_t i = 0; i < count; ++i) {
    if (std::isfinite(acceleration_of[0][i]) && std::isfinite(acceleration_of[1][i]) &&
        std::isfinite(acceleration_of[2][i]))
      continue;
    std::uint32_t least = bad_neuron.load();
    while (first + i < least && !bad_neuron.compare_exchange_weak(least, first + i)) {
    }
    return;
  }
}

void Sweep::Tiles::note_bad_neurons(std::span<const std::uint32_t> list, const double* const force_of[3],
                                    const double* const acceleration_of[3]) {
  const auto count = static_cast<std::uint32_t>(list.size());
  if (all_finite(acceleration_of, count)) return;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double* const own[3] = {force_of[0] + i, force_of[1] + i, force_of[2] + i};
    const double* const answered[3] = {acceleration_of[0] + i, acceleration_of[1] + i, acceleration_of[2] + i};
    if (all_finite(own, 1)) note_bad_neuron(list[i], 1, answered);
  }
}

springnet_status Sweep::Tiles::accelerate(std::uint32_t first, std::uint32_t count, const double* const of_tile[3],
                                          bool forces_finite, springnet_message& message) {
  double* accelerations[3] = {acceleration.x + first, acceleration.y + first, acceleration.z + first};
  const springnet_status status = model.evaluator.accelerations(first, count, time, nodes, of_tile, accelerations,
                                                                nullptr, nullptr, nullptr, message);
  if (status != SPRINGNET_OK) return status;
  if (forces_finite && !all_finite(accelerations, count)) note_bad_neuron(first, count, accelerations);
  if (free.x != nullptr) {
    std::copy_n(accelerations[0], count, free.x + first);
    std::copy_n(accelerations[1], count, free.y + first);
    std::copy_n(accelerations[2], count, free.z + first);
  }
  const profile::Part part("constraints");
  model.constraints.accelerate(*at, first, count, {nodes.px, nodes.py, nodes.pz}, {nodes.vx, nodes.vy, nodes.vz},
                               accelerations);
  return SPRINGNET_OK;
}

springnet_status Sweep::Tiles::update(std::uint32_t unit, std::uint32_t first, std::uint32_t count,
                                      const double* const of_tile[3], bool forces_finite,
                                      const layers::NodeDerivatives* derivatives, springnet_message& message) {
  alignas(64) double local[3][layers::tile_nodes];
  double* accelerations[3] = {local[0], local[1], local[2]};
  const springnet_status status = model.evaluator.accelerations(first, count, time, nodes, of_tile, accelerations,
                                                                nullptr, nullptr, nullptr, message);
  if (status != SPRINGNET_OK) return status;
  if (forces_finite && !all_finite(accelerations, count)) note_bad_neuron(first, count, accelerations);
  springnet_node_batch batch{};
  batch.struct_size = sizeof batch;
  batch.first = first;
  batch.count = count;
  batch.unit = unit;
  batch.instruction_set = layers::abi_number(model.evaluator.instruction_set());
  batch.force = {of_tile[0], of_tile[1], of_tile[2]};
  batch.acceleration = {accelerations[0], accelerations[1], accelerations[2]};
  if (derivatives != nullptr) {
    batch.acceleration_by_velocity = derivatives->by_velocity;
    batch.acceleration_by_position = derivatives->by_position;
  }
  // The old velocity, which an update in place overwrites; updates by tiles leave it in the sweep's arrays.
  Vector3 read = Vector3::Zero();
  const bool in_place = count == 1 && sweep->order != nullptr;
  if (in_place) read = {nodes.vx[first], nodes.vy[first], nodes.vz[first]};
  if (const springnet_status updated = call_update(*sweep, batch, message); updated != SPRINGNET_OK) return updated;
  const profile::Part part("constraints");
  model.constraints.push(first, count, *sweep);
  model.constraints.constrain(*at, first, count, *sweep, in_place ? &read : nullptr);
  if (in_place) return SPRINGNET_OK;
  // While they are in the first-level cache: a commit then need not look for them in memory.
  const springnet_vectors &p = sweep->next_position, &v = sweep->next_velocity;
  const double* const positions[3] = {p.x + first, p.y + first, p.z + first};
  const double* const velocities[3] = {v.x + first, v.y + first, v.z + first};
  if (!all_finite(positions, count) || !all_finite(velocities, count))
    outputs_finite.store(false, std::memory_order_relaxed);
  return SPRINGNET_OK;
}

springnet_status Sweep::Tiles::update(std::uint32_t unit, std::span<const std::uint32_t> list,
                                      const layers::ListedNodes& own, const double* const force_of[3],
                                      const double* const acceleration_of[3], springnet_message& message) {
  springnet_node_batch batch{};
  batch.struct_size = sizeof batch;
  batch.unit = unit;
  batch.instruction_set = layers::abi_number(model.evaluator.instruction_set());
  const std::size_t step = sweep->lists != 0 ? list.size() : 1;
  for (std::size_t begin = 0; begin < list.size(); begin += step) {
    batch.first = list[begin];
    batch.count = static_cast<std::uint32_t>(step);
    batch.force = {force_of[0] + begin, force_of[1] + begin, force_of[2] + begin};
    batch.acceleration = {acceleration_of[0] + begin, acceleration_of[1] + begin, acceleration_of[2] + begin};
    batch.nodes = sweep->lists != 0 ? list.data() : nullptr;
    if (const springnet_status updated = call_update(*sweep, batch, message); updated != SPRINGNET_OK) return updated;
    const profile::Part part("constraints");
    model.constraints.push(list.subspan(begin, step), *sweep);
    model.constraints.constrain(*at, list.subspan(begin, step), *sweep,
                                {own.v[0] + begin, own.v[1] + begin, own.v[2] + begin});
  }
  return SPRINGNET_OK;
}

springnet_status Sweep::finish_tile(void* user, std::uint32_t unit, std::uint32_t first, std::uint32_t count,
                                    const layers::ForceArrays& force, springnet_message& message) {
  Tiles& tiles = *static_cast<Tiles*>(user);
  const double* const of_tile[3] = {force.x, force.y, force.z};
  const bool finite = tiles.model.evaluator.all_finite(of_tile, count);
  if (!finite) tiles.finite.store(false, std::memory_order_relaxed);
  if (tiles.sweep != nullptr) return tiles.update(unit, first, count, of_tile, finite, nullptr, message);
  if (tiles.acceleration.x == nullptr) return SPRINGNET_OK;
  return tiles.accelerate(first, count, of_tile, finite, message);
}

}  // namespace springnet
