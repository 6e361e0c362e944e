// All elements at a state, batch by batch. Each writes the forces on its corners, an enclosure Q and dq/dp of each of
// its nodes; then each node sums the forces of its elements in a fixed order. So no two threads write to the same
// place, and the sums do not depend on the number of threads.

#include <omp.h>

#include <algorithm>

#include <springnet/sdk/message.hpp>

#include "layers/elements/blocks.hpp"
#include "layers/elements/several.hpp"
#include "layers/evaluator.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {

namespace {

ElementKernels::Geometry geometry_kernel(const ElementKernels& kernels, Invariant invariant) {
  switch (invariant) {
    case Invariant::angle:
      return kernels.angles;
    case Invariant::dihedral:
      return kernels.dihedrals;
    case Invariant::area:
      return kernels.areas;
    default:
      return kernels.volumes;
  }
}

}  // namespace

void Evaluator::measure(Invariant invariant, const BatchCorners& corners, const NodeArrays& nodes,
                        BatchGeometry& out) const noexcept {
  geometry_kernel(kernels_.elements, invariant)(corners, nodes, out);
  if (invariant != Invariant::angle) return;
  // Straight angles that are bending.
  for (std::size_t i = 0; i < corners.count; ++i) {
    if (out.gradient[0][i] != 0.0 || out.gradient[1][i] != 0.0 || out.gradient[2][i] != 0.0) continue;
    const std::uint32_t own[3] = {corners.corner[0][i], corners.corner[1][i], corners.corner[2][i]};
    Corners one;
    gather(own, 3, nodes, one);
    FirstOrder geometry;
    first_order(invariant, one, geometry);
    out.rate[i] = geometry.rate;
    for (std::size_t c = 0; c < 9; ++c) out.gradient[c][i] = geometry.gradient[c / 3][static_cast<Eigen::Index>(c % 3)];
  }
}

springnet_status Evaluator::evaluate_batch(const ElementBatch& batch, double time, const NodeArrays& nodes,
                                           springnet_message& message) const {
  if (reads_several(batch.invariant)) return evaluate_several_batch(batch, time, nodes, message);
  const ElementLayout& elements = layout_.elements();
  const Group& group = layout_.laws().groups[batch.group];
  BatchGeometry geometry;  // not initialised: written before it is read
  measure(batch.invariant, elements.corners(batch), nodes, geometry);
  alignas(64) double force[2][element_batch];
  const std::uint32_t* rows = elements.rows(batch);
  const springnet_status status = evaluate_laws({group,
                                                 batch.count,
                                                 batch.one_row ? RowSelection{nullptr, rows[0]} : RowSelection{rows, 0},
                                                 geometry.value,
                                                 geometry.rate,
                                                 nullptr,
                                                 {layout_.internal(), batch.group, nodes, elements.places(batch)},
                                                 nullptr,
                                                 called_for(elements, batch)},
                                                set_, time, {LawOutputs{force[0]}, LawOutputs{force[1]}}, message);
  if (status != SPRINGNET_OK) return status;
  const std::size_t pitch = elements.batched().size();
  const auto at = [&](std::vector<double>& forces) { return forces.data() + batch.begin; };
  kernels_.elements.forces(geometry, corners_of(batch.invariant), batch.count, group.spring ? force[0] : nullptr,
                           group.viscosity ? force[1] : nullptr,
                           {at(corner_force_[0]), at(corner_force_[1]), at(corner_force_[2]), pitch});
  return SPRINGNET_OK;
}

springnet_status Evaluator::evaluate_several_batch(const ElementBatch& batch, double time, const NodeArrays& nodes,
                                                   springnet_message& message) const {
  const ElementLayout& elements = layout_.elements();
  const Group& group = layout_.laws().groups[batch.group];
  const SeveralMembers members = members_of(elements, batch);
  SeveralGeometry geometry;  // not initialised: written before it is read
  kernels_.several.geometry(group.scalars, members.corners, members.reference, nodes, group.reads_rate(), geometry);
  SeveralAnswers answers;
  const springnet_status status =
      evaluate_several(group, members, geometry, set_, time, SeveralWanted::forces, answers, message);
  if (status != SPRINGNET_OK) return status;
  const double* q[2][max_scalars];
  forces_of(group, answers, q);
  const auto at = [&](std::vector<double>& forces) { return forces.data() + batch.begin; };
  kernels_.several.forces(
      group.scalars, geometry, batch.count, q,
      {at(corner_force_[0]), at(corner_force_[1]), at(corner_force_[2]), elements.batched().size()});
  return SPRINGNET_OK;
}

springnet_status Evaluator::evaluate_enclosures(double time, const NodeArrays& nodes,
                                                springnet_message& message) const {
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
    const std::uint32_t place = layout_.internal().has(elements.group(e)) ? layout_.internal().of_element(e) : 0;
    const springnet_status status = evaluate_laws({group,
                                                   1,
                                                   {nullptr, elements.row(e)},
                                                   &sum.volume,
                                                   &sum.rate,
                                                   nullptr,
                                                   {layout_.internal(), elements.group(e), nodes, &place},
                                                   nullptr,
                                                   {CalledMembers::Are::elements, 1, 1, &e}},
                                                  set_, time, answers.outputs(false, false), message);
    if (status != SPRINGNET_OK) return status;
    enclosure_force_[s] = element_force(group, answers, 0, false).force;
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
      enclosure_shares_[c] = enclosure.shape.partial_values(chunks_[c].begin, chunks_[c].end, nodes,
                                                            enclosure_gradient_[chunks_[c].enclosure].data());
    return SPRINGNET_OK;
  };
  const FlushDenormals flush;
  if (threads_ == 1) {
    for (std::int64_t i = 0; i < pieces; ++i) {
      if (const springnet_status status = evaluate_piece(i, message); status != SPRINGNET_OK) return status;
    }
    return evaluate_enclosures(time, nodes, message);
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
  return failure == SPRINGNET_OK ? evaluate_enclosures(time, nodes, message) : failure;
}

void Evaluator::add_elements(std::uint32_t begin, std::uint32_t end, const ForceArrays& force,
                             std::uint32_t origin) const noexcept {
  const ElementLayout& elements = layout_.elements();
  const double *x = corner_force_[0].data(), *y = corner_force_[1].data(), *z = corner_force_[2].data();
  const bool enclosures = elements.live_enclosures() > 0;
  for (std::uint32_t k = begin; k < end; ++k) {
    const std::span<const std::uint32_t> slots = elements.force_slots(k);
    double sum[3] = {0.0, 0.0, 0.0};
    for (const std::uint32_t slot : slots) {
      sum[0] += x[slot];
      sum[1] += y[slot];
      sum[2] += z[slot];
    }
    if (enclosures) {
      for (const ElementShare& share : elements.shares(k).subspan(slots.size())) {
        const Vector3& gradient = enclosure_gradient_[share.enclosure][share.place];
        for (Eigen::Index c = 0; c < 3; ++c) sum[c] -= enclosure_force_[share.enclosure] * gradient[c];
      }
    }
    force.x[k - origin] += sum[0];
    force.y[k - origin] += sum[1];
    force.z[k - origin] += sum[2];
  }
}

}  // namespace springnet::layers
