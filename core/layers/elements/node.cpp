// The elements of a single node: forces on it, derivative blocks, energy.

#include <limits>

#include "layers/elements/blocks.hpp"
#include "layers/node_sums.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

constexpr std::size_t chunk = 16;

// One element seen from the node.
struct Seen {
  Corners corners;        // of three or four nodes
  FirstOrder geometry;    // of three or four nodes
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
  const profile::Part part("elements");
  const bool blocks = sums.stiffness != nullptr;
  Seen seen[chunk];  // not initialised: written before it is read
  double q[chunk], rate[chunk];
  PairAnswers<chunk> answers;
  const PairOutputs out = answers.outputs(blocks, sums.energy != nullptr);
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
        const Enclosure::Values values =
            volumes != nullptr ? volumes->values_for(node, share.enclosure, own.gradient, own.rate_gradient)
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
    }
    const springnet_status status = evaluate_laws({group, count, {rows, 0}, q, rate}, set_, time, out, message);
    if (status != SPRINGNET_OK) return status;
    const std::array<const Law*, 2> laws = group.laws();
    for (std::size_t k = 0; k < laws.size() && sums.energy != nullptr; ++k) {
      if (!*laws[k]) continue;
      for (std::size_t i = 0; i < count; ++i)
        *sums.energy += laws[k]->has_potential() ? answers.energy[k][i] : std::numeric_limits<double>::quiet_NaN();
    }
    for (std::size_t i = 0; i < count; ++i) {
      const ElementShare& share = shares[begin + i];
      const ElementForce law = element_force(group, answers, i, blocks);
      sums.force -= law.force * seen[i].gradient;
      if (!blocks) continue;
      Block stiffness, damping;
      if (share.enclosure != no_enclosure) {
        // The volume is linear in the node's position, so its Hessian has no diagonal block.
        const Vector3 change = law.by_q * seen[i].gradient + law.by_rate * seen[i].rate_gradient;
        stiffness = seen[i].gradient * change.transpose();
        damping = law.by_rate * seen[i].gradient * seen[i].gradient.transpose();
      } else {
        linearise_own(elements.invariant(share.element), seen[i].corners, seen[i].geometry, law, share.place, stiffness,
                      damping);
      }
      *sums.stiffness += stiffness;
      *sums.damping += damping;
    }
    begin = end;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
