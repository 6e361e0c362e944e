#include "synchronous.hpp"

namespace springnet::recurrent {

void Synchronous::begin(Step& step) {
  if (step.compares) work_.record.begin();
}

void Synchronous::sweep(Step& step) {
  const springnet_state& read = step.newest();
  springnet_state& write = work_.state_beside(step.outputs);
  const springnet_sweep call = work_.sweep_call(step, read, write);
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

}  // namespace springnet::recurrent
