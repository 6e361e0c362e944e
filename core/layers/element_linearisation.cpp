#include "layers/element_linearisation.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace springnet::layers {

// Q and its derivatives of elements with the same laws.
springnet_status ElementLinearisation::ask(const ElementBatch& batch, double time, const std::uint32_t* members,
                                           const double* q, const double* rate, ElementForce* forces,
                                           springnet_message& message) const {
  const Group& group = layout_.laws().groups[batch.group];
  double value[element_batch], by_q[element_batch], by_rate[element_batch];
  std::uint32_t rows[element_batch];
  for (std::size_t i = 0; i < batch.count; ++i) {
    rows[i] = layout_.elements().row(members[i]);
    forces[i] = {};
  }
  for (const Law* law : {&group.spring, &group.viscosity}) {
    if (!*law) continue;
    if (require_derivatives(*law->component, message) != SPRINGNET_OK) return SPRINGNET_FAILED;
    LawOutputs out;
    out.force = value;
    out.force_by_q = by_q;
    if (law->reads_rate) out.force_by_rate = by_rate;
    const springnet_status status = call_law(group, *law, abi_number(evaluator_.instruction_set()), time, batch.count,
                                             {rows, 0}, q, rate, out, &message);
    if (status != SPRINGNET_OK) return status;
    for (std::size_t i = 0; i < batch.count; ++i) {
      forces[i].force += value[i];
      forces[i].by_q += by_q[i];
      if (law->reads_rate) forces[i].by_rate += by_rate[i];
    }
  }
  return SPRINGNET_OK;
}

springnet_status ElementLinearisation::update(double time, const NodeArrays& nodes, springnet_message& message) {
  const ElementLayout& elements = layout_.elements();
  if (elements.live_count() == 0) return SPRINGNET_OK;
  blocks_.resize(elements.batched().empty() ? 0 : elements.count());
  Corners corners[element_batch];
  FirstOrder geometry[element_batch];
  double q[element_batch], rate[element_batch];
  ElementForce forces[element_batch];
  for (const ElementBatch& batch : elements.batches()) {
    const std::uint32_t* members = elements.batched().data() + batch.begin;
    for (std::size_t i = 0; i < batch.count; ++i) {
      const std::span<const std::uint32_t> own = elements.nodes(members[i]);
      gather(own.data(), own.size(), nodes, corners[i]);
      first_order(batch.invariant, corners[i], geometry[i]);
      q[i] = nearest_turn(batch.invariant, geometry[i].value, elements.reference(members[i]));
      rate[i] = geometry[i].rate;
    }
    const springnet_status status = ask(batch, time, members, q, rate, forces, message);
    if (status != SPRINGNET_OK) return status;
    for (std::size_t i = 0; i < batch.count; ++i)
      linearise(batch.invariant, corners[i], geometry[i], forces[i], blocks_[members[i]]);
  }
  surfaces_.resize(elements.surfaces().size());
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    const std::uint32_t e = elements.surfaces()[s].element;
    if (!elements.alive(e)) continue;
    const ClosedSurface& surface = elements.surfaces()[s].surface;
    SurfaceDerivatives& own = surfaces_[s];
    const ClosedSurface::Values values = surface.values(nodes);
    const springnet_status status = ask({Invariant::enclosed_volume, elements.group(e), 0, 1}, time, &e, &values.volume,
                                        &values.rate, &own.law, message);
    if (status != SPRINGNET_OK) return status;
    own.gradient.resize(surface.size());
    own.rate_gradient.resize(surface.size());
    own.across.resize(surface.spoke_count());
    for (std::size_t place = 0; place < surface.size(); ++place) {
      own.gradient[place] = surface.gradient(place, nodes);
      own.rate_gradient[place] = surface.rate_gradient(place, nodes);
      std::size_t spoke = surface.first_spoke(place);
      for (const ClosedSurface::Spoke& to : surface.spokes(place))
        own.across[spoke++] = own.law.force * ClosedSurface::across(to, nodes);
    }
  }
  return SPRINGNET_OK;
}

void ElementLinearisation::prepare(const double* dp, const double* dv) {
  const ElementLayout& elements = layout_.elements();
  const std::size_t n = layout_.node_count();
  const auto at = [n](const double* values, std::size_t k) {
    return Vector3(values[k], values[n + k], values[2 * n + k]);
  };
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    SurfaceDerivatives& own = surfaces_[s];
    own.product = 0.0;
    if (!elements.alive(elements.surfaces()[s].element)) continue;
    const std::vector<std::uint32_t>& nodes = elements.surfaces()[s].surface.nodes();
    for (std::size_t place = 0; place < nodes.size(); ++place) {
      const Vector3 p = at(dp, nodes[place]), v = at(dv, nodes[place]);
      own.product += own.law.by_q * own.gradient[place].dot(p) +
                     own.law.by_rate * (own.rate_gradient[place].dot(p) + own.gradient[place].dot(v));
    }
  }
}

Vector3 ElementLinearisation::force(std::uint32_t node, const double* dp, const double* dv) const {
  const ElementLayout& elements = layout_.elements();
  const std::size_t n = layout_.node_count();
  const auto at = [n](const double* values, std::size_t k) {
    return Vector3(values[k], values[n + k], values[2 * n + k]);
  };
  Vector3 sum = Vector3::Zero();
  for (const ElementShare& share : elements.shares(node)) {
    if (share.surface != no_surface) {
      const SurfaceDerivatives& own = surfaces_[share.surface];
      const ClosedSurface& surface = elements.surfaces()[share.surface].surface;
      sum -= own.product * own.gradient[share.place];
      std::size_t spoke = surface.first_spoke(share.place);
      for (const ClosedSurface::Spoke& to : surface.spokes(share.place))
        sum -= own.across[spoke++].cross(at(dp, to.other));
      continue;
    }
    const ElementBlocks& blocks = blocks_[share.element];
    const std::span<const std::uint32_t> corners = elements.nodes(share.element);
    double rate[2] = {0.0, 0.0};
    for (std::size_t j = 0; j < corners.size(); ++j) {
      const Vector3 v = at(dv, corners[j]);
      sum -= blocks.stiffness[share.place][j] * at(dp, corners[j]);
      for (int r = 0; r < 2; ++r) rate[r] += blocks.row[r][j].dot(v);
    }
    sum -= blocks.damping * (rate[0] * blocks.row[0][share.place] + rate[1] * blocks.row[1][share.place]);
  }
  return sum;
}

Block ElementLinearisation::diagonal(std::uint32_t node, double velocity_weight, double position_weight,
                                     bool vectors) const {
  const ElementLayout& elements = layout_.elements();
  Block sum = Block::Zero();
  for (const ElementShare& share : elements.shares(node)) {
    if (share.surface != no_surface) {
      if (!vectors) continue;
      const SurfaceDerivatives& own = surfaces_[share.surface];
      const Vector3& g = own.gradient[share.place];
      const Vector3 weight = (position_weight * own.law.by_q + velocity_weight * own.law.by_rate) * g +
                             position_weight * own.law.by_rate * own.rate_gradient[share.place];
      sum += g * weight.transpose();
      continue;
    }
    const ElementBlocks& blocks = blocks_[share.element];
    sum += velocity_weight * blocks.damping_block(share.place, share.place) +
           position_weight * blocks.stiffness[share.place][share.place];
  }
  return sum;
}

}  // namespace springnet::layers
