// Elements whose laws read several scalars of their nodes: F_k = -sum_i Q_i dq_i/dp_k.
#pragma once

#include <cstddef>
#include <cstdint>

#include "layers/elements/layout.hpp"
#include "layers/elements/several_kernels.hpp"
#include "layers/instruction_set.hpp"
#include "layers/law_pair.hpp"

namespace springnet::layers {

// Some elements of a group, up to several_batch.
struct SeveralMembers {
  BatchCorners corners;
  const double* reference[max_scalars];  // [scalar][member]
  const double* direction[3];
  RowSelection rows;
  CalledMembers called{};
};
[[nodiscard]] inline CalledMembers called_for(const ElementLayout& elements, const ElementBatch& batch) noexcept {
  return {CalledMembers::Are::elements, batch.count, 1, elements.batched().data() + batch.begin};
}
// Those of a batch of the layout.
[[nodiscard]] SeveralMembers members_of(const ElementLayout& elements, const ElementBatch& batch) noexcept;

// Chosen elements: their corners, references and directions, gathered.
class GatheredMembers {
 public:
  GatheredMembers() = default;  // not initialised: written before it is read
  GatheredMembers(const GatheredMembers&) = delete;
  GatheredMembers& operator=(const GatheredMembers&) = delete;
  // element(i): number of the i-th of `count` elements of one group.
  template <class Element>
  const SeveralMembers& gather(const ElementLayout& elements, std::size_t count, const Element& element) noexcept {
    for (std::size_t i = 0; i < count; ++i) put(elements, i, element(i));
    return finish(count);
  }

 private:
  void put(const ElementLayout& elements, std::size_t i, std::uint32_t element) noexcept;
  const SeveralMembers& finish(std::size_t count) noexcept;

  std::uint32_t corner_[max_corners][several_batch], row_[several_batch], element_[several_batch];
  double reference_[max_scalars][several_batch], direction_[3][several_batch];
  SeveralMembers members_;
};

// What laws read of them.
[[nodiscard]] SeveralInputs inputs_of(const SeveralMembers& members, const SeveralGeometry& geometry) noexcept;
// dq/dp of the corner c of a scalar of member i; `rows` as SeveralGeometry::gradient of that scalar.
[[nodiscard]] Vector3 gradient_of(const ElementScalar& scalar, const double (*rows)[several_batch], std::size_t c,
                                  std::size_t i) noexcept;

// dq/dp of its rate likewise, of the scalar s of the list.
[[nodiscard]] Vector3 rate_gradient_of(const ElementScalar& scalar, const SeveralGeometry& geometry, std::size_t s,
                                       std::size_t c, std::size_t i) noexcept;

// What the laws of a group answered to a batch, [law]. Not initialised.
struct SeveralAnswers {
  alignas(64) double force[2][max_scalars][several_batch];
  double energy[2][several_batch];
  double margin[2][several_batch];
  double by_value[2][max_scalars * max_scalars][several_batch];
  double by_rate[2][max_scalars * max_scalars][several_batch];
};
enum class SeveralWanted : std::uint8_t { forces, forces_and_energies, margins, tangent };
// dE/dq_i of laws that have an energy and derivatives, [law][scalar][member]; 0 of the others. Not initialised.
struct SeveralEnergyGradients {
  alignas(64) double value[2][max_scalars][several_batch];
};

// Evaluates the laws at a geometry. `wanted`: what both answer beside their forces; energies and margins of laws that
// have none are nan and infinity. Throws nothing; see evaluate_laws().
springnet_status evaluate_several(const Group& group, const SeveralMembers& members, const SeveralGeometry& geometry,
                                  InstructionSet set, double time, SeveralWanted wanted, SeveralAnswers& out,
                                  springnet_message& message);
// Throws nothing, as it.
springnet_status several_energy_gradients(const Group& group, const SeveralMembers& members,
                                          const SeveralGeometry& geometry, InstructionSet set, double time,
                                          SeveralEnergyGradients& out, springnet_message& message);
// The forces of both laws for the kernels: null for scalars that a law does not read.
void forces_of(const Group& group, const SeveralAnswers& answers, const double* (&out)[2][max_scalars]) noexcept;
// Sums up what both laws answered with SeveralWanted::tangent. False: a number is not finite.
[[nodiscard]] bool tangent_of(const Kernels& kernels, const Group& group, const SeveralAnswers& answers,
                              std::size_t count, SeveralTangent& out) noexcept;

// All blocks of up to several_at_once members of a batch, from `begin` on, a multiple of that.
void several_blocks(const Kernels& kernels, const ScalarList& list, const SeveralGeometry& geometry, std::size_t begin,
                    std::size_t count, const SeveralTangent& tangent, SeveralRateGradients& rate_gradients,
                    SeveralBlocks& out) noexcept;
// Diagonal blocks of one corner of member i.
void several_own_blocks(const ScalarList& list, const SeveralGeometry& geometry, std::size_t i,
                        const SeveralTangent& tangent, std::size_t corner, Block& stiffness, Block& damping) noexcept;

}  // namespace springnet::layers
