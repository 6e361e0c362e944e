#include "simulation/sweep_tiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include <springnet/sdk/message.hpp>

#include "constraints/vectors.hpp"
#include "profile/stage.hpp"

namespace springnet {
namespace {

// In integers, so that the loop vectorises: adding 1 to an exponent of all ones overflows into the sign bit.
bool all_finite(const double* values, std::uint32_t count) noexcept {
  constexpr std::uint64_t magnitude = ~std::uint64_t{0} >> 1, one = std::uint64_t{1} << 52;
  std::uint64_t top = 0;
  for (std::uint32_t i = 0; i < count; ++i) top |= (std::bit_cast<std::uint64_t>(values[i]) & magnitude) + one;
  return top >> 63 == 0;
}

// Calls the integrator's update, which must not throw; if it does, the sweep ends with a message.
springnet_status call_update(const springnet_sweep& sweep, const springnet_node_batch& batch,
                             springnet_message& message) noexcept {
  const profile::Part part("update");
  try {
    sweep.update(sweep.user, &batch);
    return SPRINGNET_OK;
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

bool Sweep::Tiles::all_finite(const double* const values[3], std::uint32_t count) noexcept {
  return springnet::all_finite(values[0], count) && springnet::all_finite(values[1], count) &&
         springnet::all_finite(values[2], count);
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

springnet_status Sweep::Tiles::accelerate(std::uint32_t first, std::uint32_t count, bool forces_finite,
                                          springnet_message& message) {
  const double* of_tile[3] = {force.x + first, force.y + first, force.z + first};
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

springnet_status Sweep::Tiles::update(std::uint32_t unit, std::uint32_t first, std::uint32_t count, bool forces_finite,
                                      const layers::NodeDerivatives* derivatives, springnet_message& message) {
  const double* of_tile[3] = {force.x + first, force.y + first, force.z + first};
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
  model.constraints.constrain(*at, first, count, *sweep, in_place ? &read : nullptr);
  return SPRINGNET_OK;
}

springnet_status Sweep::Tiles::update(std::uint32_t unit, std::span<const std::uint32_t> list,
                                      const layers::ListedNodes& own, const double* const force_of[3],
                                      const double* const acceleration_of[3], springnet_message& message) {
  springnet_node_batch batch{};
  batch.struct_size = sizeof batch;
  batch.unit = unit;
  const std::size_t step = sweep->lists != 0 ? list.size() : 1;
  for (std::size_t begin = 0; begin < list.size(); begin += step) {
    batch.first = list[begin];
    batch.count = static_cast<std::uint32_t>(step);
    batch.force = {force_of[0] + begin, force_of[1] + begin, force_of[2] + begin};
    batch.acceleration = {acceleration_of[0] + begin, acceleration_of[1] + begin, acceleration_of[2] + begin};
    batch.nodes = sweep->lists != 0 ? list.data() : nullptr;
    if (const springnet_status updated = call_update(*sweep, batch, message); updated != SPRINGNET_OK) return updated;
    const profile::Part part("constraints");
    model.constraints.constrain(*at, list.subspan(begin, step), *sweep,
                                {own.v[0] + begin, own.v[1] + begin, own.v[2] + begin});
  }
  return SPRINGNET_OK;
}

springnet_status Sweep::finish_tile(void* user, std::uint32_t unit, std::uint32_t first, std::uint32_t count,
                                    springnet_message& message) {
  Tiles& tiles = *static_cast<Tiles*>(user);
  const double* force[3] = {tiles.force.x + first, tiles.force.y + first, tiles.force.z + first};
  const bool finite = Tiles::all_finite(force, count);
  if (!finite) tiles.finite.store(false, std::memory_order_relaxed);
  if (tiles.sweep != nullptr) return tiles.update(unit, first, count, finite, nullptr, message);
  if (tiles.acceleration.x == nullptr) return SPRINGNET_OK;
  return tiles.accelerate(first, count, finite, message);
}

}  // namespace springnet
