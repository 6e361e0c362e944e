// All elements at a state, batch by batch. Each writes its Q, and dq/dp of each of its nodes; then each node sums the
// forces of its elements in a fixed order. So no two threads write to the same place, and the sums do not depend on the
// number of threads.

#include <omp.h>

#include <algorithm>

#include <springnet/sdk/message.hpp>

#include "layers/elements/blocks.hpp"
#include "layers/evaluator.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {

springnet_status Evaluator::evaluate_batch(const ElementBatch& batch, double time, const NodeArrays& nodes,
                                           springnet_message& message) const {
  const ElementLayout& elements = layout_.elements();
  const Group& group = layout_.laws().groups[batch.group];
  double q[element_batch], rate[element_batch];
  PairAnswers<element_batch> answers;
  std::uint32_t rows[element_batch];
  const std::uint32_t* members = elements.batched().data() + batch.begin;
  for (std::size_t i = 0; i < batch.count; ++i) {
    const std::span<const std::uint32_t> own = elements.nodes(members[i]);
    Corners corners;  // not initialised: written before it is read
    FirstOrder geometry;
    gather(own.data(), own.size(), nodes, corners);
    first_order(batch.invariant, corners, geometry);
    q[i] = nearest_turn(batch.invariant, geometry.value, elements.reference(members[i]));
    rate[i] = geometry.rate;
    rows[i] = elements.row(members[i]);
    std::copy_n(geometry.gradient, own.size(), element_gradient_.data() + elements.slot(members[i]));
  }
  const springnet_status status =
      evaluate_laws({group, batch.count, {rows, 0}, q, rate}, set_, time, answers.outputs(false, false), message);
  if (status != SPRINGNET_OK) return status;
  for (std::size_t i = 0; i < batch.count; ++i)
    element_force_[members[i]] = element_force(group, answers, i, false).force;
  return SPRINGNET_OK;
}

springnet_status Evaluator::evaluate_enclosures(double time, springnet_message& message) const {
  const ElementLayout& elements = layout_.elements();
  std::size_t next = 0;
  for (std::uint32_t s = 0; s < elements.enclosures().size(); ++s) {
    const std::uint32_t e = elements.enclosures()[s].element;
    Enclosure::Values sum;
    for (; next < chunks_.size() && chunks_[next].enclosure == s; ++next) {
      sum.volume += enclosure_shares_[next].volume;
      sum.rate += enclosure_shares_[next].rate;
    }
    if (!elements.alive(e)) continue;
    const profile::Tile measured;
    const profile::Part part("elements");
    const Group& group = layout_.laws().groups[elements.group(e)];
    PairAnswers<1> answers;
    const springnet_status status = evaluate_laws({group, 1, {nullptr, elements.row(e)}, &sum.volume, &sum.rate}, set_,
                                                  time, answers.outputs(false, false), message);
    if (status != SPRINGNET_OK) return status;
    element_force_[e] = element_force(group, answers, 0, false).force;
  }
  return SPRINGNET_OK;
}

springnet_status Evaluator::evaluate_elements(double time, const NodeArrays& nodes, springnet_message& message) const {
  const ElementLayout& elements = layout_.elements();
  const auto batches = static_cast<std::int64_t>(elements.batches().size());
  const auto pieces = batches + static_cast<std::int64_t>(elements.live_enclosures() > 0 ? chunks_.size() : 0);
  const auto evaluate_piece = [&](std::int64_t i, springnet_message& own_message) -> springnet_status {
    const profile::Tile measured;
    const profile::Part part("elements");
    if (i < batches) return evaluate_batch(elements.batches()[static_cast<std::size_t>(i)], time, nodes, own_message);
    const auto c = static_cast<std::size_t>(i - batches);
    const ElementLayout::EnclosureElement& enclosure = elements.enclosures()[chunks_[c].enclosure];
    if (elements.alive(enclosure.element))
      enclosure_shares_[c] = enclosure.shape.partial_values(
          chunks_[c].begin, chunks_[c].end, nodes, element_gradient_.data() + elements.slot(enclosure.element));
    return SPRINGNET_OK;
  };
  const FlushDenormals flush;
  if (threads_ == 1) {
    for (std::int64_t i = 0; i < pieces; ++i) {
      if (const springnet_status status = evaluate_piece(i, message); status != SPRINGNET_OK) return status;
    }
    return evaluate_enclosures(time, message);
  }
  std::int64_t failed = pieces;
  springnet_status failure = SPRINGNET_OK;
  {
    const profile::Region region(threads_);
#pragma omp parallel num_threads(static_cast <int>(threads_))
    {
      const FlushDenormals flush_thread;
      const profile::Share share(region, omp_get_thread_num(), omp_get_num_threads());
#pragma omp for schedule(static) nowait
      for (std::int64_t i = 0; i < pieces; ++i) {
        springnet_message own_message{};
        const springnet_status status =
            sdk::detail::guarded(&own_message, [&] { return evaluate_piece(i, own_message); });
        if (status == SPRINGNET_OK) continue;
#pragma omp critical(springnet_evaluate_elements)
        if (i < failed) {
          failed = i;
          failure = status;
          message = own_message;
        }
      }
    }
  }
  return failure == SPRINGNET_OK ? evaluate_enclosures(time, message) : failure;
}

void Evaluator::add_elements(std::uint32_t begin, std::uint32_t end, const ForceArrays& force) const noexcept {
  const ElementLayout& elements = layout_.elements();
  for (std::uint32_t k = begin; k < end; ++k) {
    Vector3 sum = Vector3::Zero();
    for (const ElementShare& share : elements.shares(k))
      sum -= element_force_[share.element] * element_gradient_[elements.slot(share.element) + share.place];
    force.x[k] += sum[0];
    force.y[k] += sum[1];
    force.z[k] += sum[2];
  }
}

}  // namespace springnet::layers
