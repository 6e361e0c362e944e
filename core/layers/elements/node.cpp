// The elements of one node at the newest outputs of all others.

#include <limits>

#include "layers/elements/blocks.hpp"
#include "layers/node_sums.hpp"

namespace springnet::layers {
namespace {

constexpr std::size_t chunk = 16;

// One element as a node sees it.
struct Seen {
  Corners corners;        // of three or four nodes
  FirstOrder geometry;    // likewise
  Vector3 gradient;       // dq/dp of the node
  Vector3 rate_gradient;  // dq'/dp, of an enclosure
};

}  // namespace

springnet_status Evaluator::add_elements_of(std::uint32_t node, double time, const NodeArrays& nodes,
                                            const EnclosureVolumes* volumes, NodeSums& sums,
                                            springnet_message& message) const {
  const ElementLayout& elements = layout_.elements();
  const std::span<const ElementShare> shares = elements.shares(node);
  if (shares.empty()) return SPRINGNET_OK;
  const bool blocks = sums.stiffness != nullptr;
  Seen seen[chunk];  // not initialised: written before it is read
  double q[chunk], rate[chunk], value[chunk], by_q[chunk], by_rate[chunk], energy[chunk];
  ElementForce forces[chunk];
  std::uint32_t rows[chunk];
  for (std::size_t begin = 0; begin < shares.size();) {
    std::size_t end = begin + 1;
    while (end < shares.size() && end - begin < chunk && shares[end].group == shares[begin].group) ++end;
    const std::size_t count = end - begin;
    const Group& group = layout_.laws().groups[shares[begin].group];
    for (std::size_t i = 0; i < count; ++i) {
      const ElementShare& share = shares[begin + i];
      Seen& own = seen[i];
      if (share.enclosure != no_enclosure) {
        const Enclosure& enclosure = elements.enclosures()[share.enclosure].shape;
        own.gradient = enclosure.gradient(share.place, nodes);
        own.rate_gradient = enclosure.rate_gradient(share.place, nodes);
        const Enclosure::Values values = volumes != nullptr
                                             ? volumes->seen_by(node, share.enclosure, own.gradient, own.rate_gradient)
                                             : enclosure.values(nodes);
        q[i] = values.volume;
        rate[i] = values.rate;
      } else {
        const std::span<const std::uint32_t> corners = elements.nodes(share.element);
        gather(corners.data(), corners.size(), nodes, own.corners);
        first_order(elements.invariant(share.element), own.corners, own.geometry);
        own.gradient = own.geometry.gradient[share.place];
        q[i] = nearest_turn(elements.invariant(share.element), own.geometry.value, elements.reference(share.element));
        rate[i] = own.geometry.rate;
      }
      rows[i] = elements.row(share.element);
      forces[i] = {};
    }
    for (const Law* law : {&group.spring, &group.viscosity}) {
      if (!*law) continue;
      LawOutputs out;
      out.force = value;
      if (blocks) {
        if (require_derivatives(*law->component, message) != SPRINGNET_OK) return SPRINGNET_FAILED;
        out.force_by_q = by_q;
        if (law->reads_rate) out.force_by_rate = by_rate;
      }
      const bool potential = law->can(SPRINGNET_HAS_ENERGY) && !law->reads_rate;
      if (sums.energy != nullptr && potential) out.energy = energy;
      const springnet_status status =
          call_law(group, *law, abi_number(set_), time, count, {rows, 0}, q, rate, out, &message);
      if (status != SPRINGNET_OK) return status;
      for (std::size_t i = 0; i < count; ++i) {
        forces[i].force += value[i];
        if (blocks) forces[i].by_q += by_q[i];
        if (blocks && law->reads_rate) forces[i].by_rate += by_rate[i];
        if (sums.energy != nullptr) *sums.energy += potential ? energy[i] : std::numeric_limits<double>::quiet_NaN();
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const ElementShare& share = shares[begin + i];
      sums.force -= forces[i].force * seen[i].gradient;
      if (!blocks) continue;
      Block stiffness, damping;
      if (share.enclosure != no_enclosure) {
        // The volume is linear in the node's position.
        const Vector3 change = forces[i].by_q * seen[i].gradient + forces[i].by_rate * seen[i].rate_gradient;
        stiffness = seen[i].gradient * change.transpose();
        damping = forces[i].by_rate * seen[i].gradient * seen[i].gradient.transpose();
      } else {
        linearise_own(elements.invariant(share.element), seen[i].corners, seen[i].geometry, forces[i], share.place,
                      stiffness, damping);
      }
      *sums.stiffness += stiffness;
      *sums.damping += damping;
    }
    begin = end;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
