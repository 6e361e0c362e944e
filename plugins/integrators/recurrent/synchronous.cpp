#include "synchronous.hpp"

namespace springnet::recurrent {

void Synchronous::begin(Step& step) {
  if (step.compares) work_.record.begin();
}

void Synchronous::sweep(Step& step) {
  const springnet_state& read = step.newest();
  springnet_state& write = work_.state_beside(step.outputs);
  springnet_sweep call = work_.sweep_call(step, read, write);
  if (!step.compares) call.force = {};  // a single sweep: nobody reads them
  const NodeUpdate update(step.weight(), step.free_position, step.free_velocity, write);
  ForceRecord& record = work_.record;
  record.begin_sweep();
  work_.host.sweep(call, [&](const springnet_node_batch& batch) {
    record.take_finite(batch, update(batch));
    if (step.compares) record.take(step.network, batch);
  });
  ++step.sweeps;
  step.outputs = &write;
  step.evaluated = false;
  if (step.compares) step.differences = record.differences(step.network);
  step.finite = record.finite();
}

void Synchronous::linear_sweep(Step& step) {
  const std::size_t size = 3 * std::size_t{step.network.node_count};
  double *p = step.outputs->position.x, *u = step.outputs->velocity.x;
  acceleration_.resize(size);
  work_.host.jacobian_times(p, u, acceleration_.data());
  for (std::size_t i = 0; i < size; ++i) {
    u[i] = step.weight() * acceleration_[i];
    p[i] = step.weight() * u[i];
  }
}

}  // namespace springnet::recurrent
