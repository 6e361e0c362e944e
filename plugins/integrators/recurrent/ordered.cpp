#include "ordered.hpp"

namespace springnet::recurrent {

void Ordered::begin(Step& step) {
  const springnet_state& outputs = work_.outputs_in_place(step);
  work_.evaluate(step, outputs);
  work_.record.begin(step.network, sdk::view(outputs.force), work_.acceleration().view());
}

void WavefrontRule::attach(const springnet_network&) {
  const springnet_network& network = work_.host.network_with_neighbours();
  order_.attach(network);
  if (block_) memory_.attach(network);
}

// "During the first propagation, the node with the greatest force vector is identified": the springs are evaluated at
// the frozen activities, with the loads of the new step, so that a load which moved takes the start node with it.
void WavefrontRule::begin(Step& step) {
  Ordered::begin(step);
  step.start_node = order_.strongest(step.network, sdk::view(step.outputs->force));
}

const double* WavefrontRule::relaxed_inertia(const Step& step) {
  memory_.inertia.assign(9 * std::size_t{step.network.node_count}, 0.0);
  for (std::uint32_t k = 0; k < step.network.node_count; ++k)
    for (std::size_t axis = 0; axis < 3; ++axis)
      memory_.inertia[9 * std::size_t{k} + 4 * axis] = step.network.mass[k] / step.relaxation;
  return memory_.inertia.data();
}

template <class Go>
void WavefrontRule::with_update(Step& step, std::span<const std::uint32_t> order, const Go& go) {
  const springnet_state& outputs = *step.outputs;
  springnet_sweep call = work_.sweep_call(step, outputs, outputs);
  call.order = order.data();
  call.order_count = static_cast<std::uint32_t>(order.size());
  if (!block_) {
    call.lists = 1;
    if (step.relaxation != 1.0 && step.may_be_constrained()) call.inertia = relaxed_inertia(step);
    go(call, NodeUpdate(step.weight(), step.free_position, step.free_velocity, outputs, step.relaxation));
    return;
  }
  const BlockUpdate update(work_.host, step, memory_);
  update.request(call);
  go(call, update);
}

void WavefrontRule::sweep(Step& step) {
  if (step.sweeps == 0 || !step.keeps_order) {
    if (step.differences.free_node != no_node) step.start_node = step.differences.free_node;
    sweep_order_ = order_.order(step.network, step.start_node, sdk::view(step.outputs->force));
  }
  with_update(step, sweep_order_,
              [&](const springnet_sweep& call, const auto& update) { sweep_with(step, call, update); });
}

// In the order of the first sweep of a run. Later ones begin elsewhere, which moves the limit by some per cent.
void WavefrontRule::begin_linear(const Step& step) {
  const springnet_const_vectors force = sdk::view(step.start.force);
  linear_order_ = order_.order(step.network, order_.strongest(step.network, force), force);
}

void WavefrontRule::linear_sweep(Step& step) {
  with_update(step, linear_order_,
              [&](const springnet_sweep& call, const auto& update) { work_.host.linear_sweep(call, update); });
}

void Coloured::attach(const springnet_network&) {
  const springnet_network& network = work_.host.network_with_neighbours();
  colours_.attach(network);
  memory_.attach(network);
}

springnet_sweep Coloured::call_in_order(const Step& step) {
  springnet_sweep call = work_.sweep_call(step, *step.outputs, *step.outputs);
  call.order = colours_.order().data();
  call.order_count = static_cast<std::uint32_t>(colours_.order().size());
  return call;
}

void Coloured::sweep(Step& step) {
  springnet_sweep call = call_in_order(step);
  call.set_start = colours_.set_start().data();
  call.set_count = static_cast<std::uint32_t>(colours_.set_start().size() - 1);
  const BlockUpdate update(work_.host, step, memory_);
  update.request(call);
  sweep_with(step, call, update);
}

void Coloured::linear_sweep(Step& step) {
  springnet_sweep call = call_in_order(step);
  const BlockUpdate update(work_.host, step, memory_);
  update.request(call);
  work_.host.linear_sweep(call, update);
}

}  // namespace springnet::recurrent
