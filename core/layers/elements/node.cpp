// The elements of a single node: forces on it, derivative blocks, energy.

#include <limits>

#include "layers/elements/blocks.hpp"
#include "layers/node_sums.hpp"
#include "profile/stage.hpp"

namespace springnet::layers {
namespace {

constexpr std::size_t element_chunk = 16;

// Elements of one group and invariant, or enclosures of one group, seen from a node.
struct Seen {
  double q[element_chunk], rate[element_chunk];
  Vector3 gradient[element_chunk];       // dq/dp of the node
  Vector3 rate_gradient[element_chunk];  // dq'/dp, of an enclosure
  BatchGeometry geometry;                // of elements of three or four nodes
  std::uint32_t corner[max_corners][element_chunk];
  std::uint32_t rows[element_chunk];
  std::uint32_t places[element_chunk];  // of internal states; written if there are any

  void read_enclosures(const ElementLayout& elements, std::span<const ElementShare> shares, std::uint32_t node,
                       const NodeArrays& nodes, const EnclosureVolumes* volumes) {
    for (std::size_t i = 0; i < shares.size(); ++i) {
      const ElementShare& share = shares[i];
      const Enclosure& enclosure = elements.enclosures()[share.enclosure].shape;
      gradient[i] = enclosure.gradient(share.place, nodes);
      rate_gradient[i] = enclosure.rate_gradient(share.place, nodes);
      const Enclosure::Values values = volumes != nullptr
                                           ? volumes->values_for(node, share.enclosure, gradient[i], rate_gradient[i])
                                           : enclosure.values(nodes);
      q[i] = values.volume;
      rate[i] = values.rate;
    }
  }
  // What linearise_own() reads of element i.
  void read_one(std::size_t i, std::size_t count, const NodeArrays& nodes, Corners& corners, FirstOrder& first) const {
    std::uint32_t own[max_corners];
    for (std::size_t c = 0; c < count; ++c) {
      own[c] = corner[c][i];
      first.gradient[c] = {geometry.gradient[3 * c][i], geometry.gradient[3 * c + 1][i],
                           geometry.gradient[3 * c + 2][i]};
    }
    gather(own, count, nodes, corners);
    first.value = geometry.value[i];
    first.rate = geometry.rate[i];
  }
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
  Seen seen;  // not initialised: written before it is read
  PairAnswers<element_chunk> answers;
  const PairOutputs out = answers.outputs(blocks, sums.energy != nullptr);
  for (std::size_t begin = 0; begin < shares.size();) {
    const ElementShare& first = shares[begin];
    const Invariant invariant = elements.invariant(first.element);
    const bool enclosures = first.enclosure != no_enclosure;
    std::size_t end = begin + 1;
    while (end < shares.size() && end - begin < element_chunk && shares[end].group == first.group &&
           elements.invariant(shares[end].element) == invariant)
      ++end;
    const std::size_t count = end - begin;
    if (reads_several(invariant)) {
      const springnet_status status = add_several_of(shares.subspan(begin, count), time, nodes, sums, message);
      if (status != SPRINGNET_OK) return status;
      begin = end;
      continue;
    }
    const Group& group = layout_.laws().groups[first.group];
    for (std::size_t i = 0; i < count; ++i) seen.rows[i] = elements.row(shares[begin + i].element);
    if (layout_.internal().has(first.group))
      for (std::size_t i = 0; i < count; ++i) seen.places[i] = layout_.internal().of_element(shares[begin + i].element);
    if (enclosures) {
      seen.read_enclosures(elements, shares.subspan(begin, count), node, nodes, volumes);
    } else {
      double reference[element_chunk];
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t e = shares[begin + i].element;
        const std::span<const std::uint32_t> own = elements.nodes(e);
        for (std::size_t c = 0; c < own.size(); ++c) seen.corner[c][i] = own[c];
        reference[i] = elements.reference(e);
      }
      measure(invariant, {{seen.corner[0], seen.corner[1], seen.corner[2], seen.corner[3]}, reference, count}, nodes,
              seen.geometry);
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t row = 3 * std::size_t{shares[begin + i].place};
        seen.gradient[i] = {seen.geometry.gradient[row][i], seen.geometry.gradient[row + 1][i],
                            seen.geometry.gradient[row + 2][i]};
      }
    }
    const springnet_status status = evaluate_laws({group,
                                                   count,
                                                   {seen.rows, 0},
                                                   enclosures ? seen.q : seen.geometry.value,
                                                   enclosures ? seen.rate : seen.geometry.rate,
                                                   nullptr,
                                                   {layout_.internal(), first.group, nodes, seen.places},
                                                   nullptr,
                                                   {CalledMembers::Are::elements, static_cast<std::uint32_t>(count),
                                                    sizeof(ElementShare) / sizeof(std::uint32_t), &first.element}},
                                                  set_, time, out, message);
    if (status != SPRINGNET_OK) return status;
    const std::array<const Law*, 2> laws = group.laws();
    for (std::size_t k = 0; k < laws.size() && sums.energy != nullptr; ++k) {
      if (!*laws[k]) continue;
      for (std::size_t i = 0; i < count; ++i)
        *sums.energy += laws[k]->has_potential() ? answers.energy[k][i] : std::numeric_limits<double>::quiet_NaN();
    }
    for (std::size_t i = 0; i < count; ++i) {
      const ElementForce law = element_force(group, answers, i, blocks);
      sums.force -= law.force * seen.gradient[i];
      if (!blocks) continue;
      Block stiffness, damping;
      if (enclosures) {
        // The volume is linear in the node's position, so its Hessian has no diagonal block.
        const Vector3 change = law.by_q * seen.gradient[i] + law.by_rate * seen.rate_gradient[i];
        stiffness = seen.gradient[i] * change.transpose();
        damping = law.by_rate * seen.gradient[i] * seen.gradient[i].transpose();
      } else {
        Corners corners;
        FirstOrder geometry;
        seen.read_one(i, corners_of(invariant), nodes, corners, geometry);
        linearise_own(invariant, corners, geometry, law, shares[begin + i].place, stiffness, damping);
      }
      *sums.stiffness += stiffness;
      *sums.damping += damping;
    }
    begin = end;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
