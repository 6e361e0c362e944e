// The elements of a single node whose laws read several scalars: forces on it, derivative blocks, energy.

#include <limits>

#include "layers/elements/several.hpp"
#include "layers/evaluator.hpp"
#include "layers/node_sums.hpp"

namespace springnet::layers {

springnet_status Evaluator::add_several_of(std::span<const ElementShare> shares, double time, const NodeArrays& nodes,
                                           NodeSums& sums, springnet_message& message) const {
  const Group& group = layout_.laws().groups[shares.front().group];
  const ScalarList& list = group.scalars;
  const bool blocks = sums.stiffness != nullptr, energies = sums.energy != nullptr;
  GatheredMembers gathered;
  const SeveralMembers& members =
      gathered.gather(layout_.elements(), shares.size(), [&](std::size_t i) { return shares[i].element; });
  SeveralGeometry geometry;  // not initialised: written before it is read
  kernels_.several.geometry(list, members.corners, members.reference, nodes, group.reads_rate(), geometry);
  SeveralAnswers answers;
  const auto evaluate = [&](SeveralWanted wanted) {
    return evaluate_several(group, members, geometry, set_, time, wanted, answers, message);
  };
  if (energies) {
    if (const springnet_status status = evaluate(SeveralWanted::forces_and_energies); status != SPRINGNET_OK)
      return status;
    for (std::size_t k = 0; k < 2; ++k) {
      const Law& law = *group.laws()[k];
      for (std::size_t i = 0; law && i < shares.size(); ++i)
        *sums.energy += law.has_potential() ? answers.energy[k][i] : std::numeric_limits<double>::quiet_NaN();
    }
  }
  const springnet_status status = evaluate(blocks ? SeveralWanted::tangent : SeveralWanted::forces);
  if (status != SPRINGNET_OK) return status;
  const double* q[2][max_scalars];
  forces_of(group, answers, q);
  double force[3][max_corners * several_batch];
  kernels_.several.forces(list, geometry, shares.size(), q, {force[0], force[1], force[2], several_batch});
  SeveralTangent tangent;
  if (blocks) static_cast<void>(tangent_of(kernels_, group, answers, shares.size(), tangent));
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const std::size_t at = shares[i].place * several_batch + i;
    sums.force += Vector3(force[0][at], force[1][at], force[2][at]);
    if (!blocks) continue;
    Block stiffness, damping;
    several_own_blocks(list, geometry, i, tangent, shares[i].place, stiffness, damping);
    *sums.stiffness += stiffness;
    *sums.damping += damping;
  }
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
