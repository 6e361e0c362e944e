// Evaluations of the layers at a state, without updates of nodes.

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <mutex>

#include "constraints/vectors.hpp"
#include "plugin_host/message.hpp"
#include "simulation/reactions_at.hpp"
#include "simulation/sweep_tiles.hpp"

namespace springnet {

bool Sweep::check_finite(bool forces, std::uint32_t bad_neuron, double time, const layers::NodeArrays& nodes) {
  if (forces && bad_neuron == ConstraintRow::no_node) return true;
  if (!forces) {
    model_.explain(time, nodes);
  } else if (model_.journal.non_finite.empty()) {
    const layers::Layout& layout = model_.layout;
    model_.journal.non_finite = fmt::format("neuron '{}' answered an acceleration that is not finite for node {}",
                                            layout.laws().neurons[layout.neuron_kind()[bad_neuron]].component->id(),
                                            model_.user_number(bad_neuron));
  }
  return false;
}

springnet_status Sweep::evaluate(const springnet_evaluation& wanted) {
  springnet_evaluation request{};
  std::memcpy(&request, &wanted, std::min<std::size_t>(sizeof request, wanted.struct_size));
  const std::shared_ptr<const Placement> at = model_.placement(request.time);
  const layers::InternalView internal = model_.internal_for(request.internal);
  const layers::ForceArrays force{request.force.x, request.force.y, request.force.z};  // null: not wanted
  Tiles tiles{model_, at.get(), request.time,         node_arrays(request.position, request.velocity, internal),
              force,  nullptr,  request.acceleration, request.free_acceleration};
  const springnet_status status = model_.evaluator.evaluate(request.time, tiles.nodes, model_.external_at(request.time),
                                                            tiles.force, {finish_tile, &tiles}, model_.journal.message);
  if (status != SPRINGNET_OK) return model_.failed(status, request.time, tiles.nodes);
  if (!check_finite(tiles.finite, tiles.bad_neuron, request.time, tiles.nodes)) {
    set_message(model_.journal.message, model_.journal.non_finite);
    return SPRINGNET_RECOVERABLE;
  }
  if (request.acceleration.x == nullptr) return SPRINGNET_OK;
  model_.constraints.accelerate_clusters(*at, request.position, request.velocity, request.acceleration);
  if (!model_.constraints.bodies().located()) return SPRINGNET_OK;
  layers::InternalView states = internal;
  states.next = states.rates = nullptr;
  ReactionsAt reactions(model_, request.time, request.position, request.velocity, states, at);
  const BodyMotion* pushed = nullptr;
  if (const springnet_status answer = reactions.bodies(pushed); answer != SPRINGNET_OK) return answer;
  if (pushed == nullptr) return SPRINGNET_OK;
  for (const auto& [node, own] : pushed->nodes())
    if (model_.contact.fixed()[node] == 0) put_vector(request.acceleration, node, own.acceleration);
  return SPRINGNET_OK;
}

springnet_status Sweep::evaluate_nodes(const springnet_evaluation& request) {
  const std::uint32_t* const nodes = request.nodes;
  const std::uint32_t count = request.node_count;
  model_.layout.need_incidence();
  springnet_evaluation wanted{};
  std::memcpy(&wanted, &request, std::min<std::size_t>(sizeof wanted, request.struct_size));
  const layers::FlushDenormals flush;
  layers::InternalView internal = model_.internal_for(wanted.internal);
  internal.next = internal.rates = nullptr;  // of all elements, or none
  const layers::NodeArrays arrays = node_arrays(wanted.position, wanted.velocity, internal);
  const layers::ExternalForces external = model_.external_at(wanted.time);  // the same for all threads of a sweep
  const layers::EnclosureVolumes* volumes = nullptr;
  if (model_.layout.elements().live_enclosures() > 0) {
    if (swept_volumes_.follows(arrays)) {
      volumes = &swept_volumes_;
    } else if (!in_sets_ && !in_tiles_) {
      evaluated_volumes_.compute(model_.layout.elements(), arrays);
      volumes = &evaluated_volumes_;
    }
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t k = nodes[i];
    Vector3 force, a = Vector3::Zero();
    layers::NodeDerivatives derivatives;
    const bool blocks = wanted.acceleration_by_velocity != nullptr || wanted.acceleration_by_position != nullptr;
    springnet_message message{};
    const springnet_status status =
        wanted.acceleration.x == nullptr && !blocks && wanted.energy == nullptr
            ? model_.evaluator.evaluate_node(k, wanted.time, arrays, external, volumes, force, message)
            : model_.evaluator.evaluate_node(k, wanted.time, arrays, external, volumes, force, a,
                                             blocks ? &derivatives : nullptr,
                                             wanted.energy == nullptr ? nullptr : wanted.energy + k, message);
    if (status != SPRINGNET_OK) {
      const std::lock_guard guard(model_.journal.failure_lock);
      model_.journal.message = message;
      return in_sets_ ? status : model_.failed(status, wanted.time, arrays);
    }
    if (!force.allFinite() || !a.allFinite()) {
      const std::lock_guard guard(model_.journal.failure_lock);
      if (!in_sets_) static_cast<void>(check_finite(force.allFinite(), k, wanted.time, arrays));
      set_message(model_.journal.message, model_.journal.non_finite);
      return SPRINGNET_RECOVERABLE;
    }
    if (wanted.force.x != nullptr) put_vector(wanted.force, k, force);
    if (wanted.acceleration.x != nullptr) put_vector(wanted.acceleration, k, a);
    if (wanted.acceleration_by_velocity != nullptr)
      std::copy_n(derivatives.by_velocity, 9, wanted.acceleration_by_velocity + 9 * std::size_t{k});
    if (wanted.acceleration_by_position != nullptr)
      std::copy_n(derivatives.by_position, 9, wanted.acceleration_by_position + 9 * std::size_t{k});
  }
  return SPRINGNET_OK;
}

}  // namespace springnet
