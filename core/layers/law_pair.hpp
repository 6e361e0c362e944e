// The two laws of a spring or element, its spring function and its viscosity function, evaluated on a batch. All laws
// are called here.
#pragma once

#include <array>
#include <cstddef>

#include <springnet/current_call.hpp>
#include <springnet/sdk/law/jacobian.hpp>

#include "layers/instruction_set.hpp"
#include "layers/kernels.hpp"
#include "layers/laws.hpp"

namespace springnet::layers {

// Rows of the members of a batch: one for all, or one each, by their numbers or by their values.
struct RowSelection {
  const std::uint32_t* rows = nullptr;
  std::uint32_t row = 0;                   // of all, if both others are null
  const double* const* columns = nullptr;  // [column][member], null for a column that is the same in all rows
};

// The internal state of the members of a batch; no group: they have none.
struct InternalSelection {
  const InternalView* view = nullptr;  // null: states are those that the laws declare
  const InternalLayout::OfGroup* group = nullptr;
  const std::uint32_t* place = nullptr;  // [member], see InternalLayout::silent

  InternalSelection() = default;
  InternalSelection(const InternalLayout& layout, std::size_t group_index, const NodeArrays& nodes,
                    const std::uint32_t* places) noexcept {
    if (!layout.has(group_index)) return;
    view = nodes.internal;
    group = &layout.group(group_index);
    place = places;
  }
};

// What laws over several scalars read, by the list of their group: [scalar][count]; null where no law reads it.
struct SeveralInputs {
  const double* value[max_scalars];
  const double* rate[max_scalars];
  const double* reference[max_scalars];
  const double* direction[3];
};
// Where one of them writes, by that list: Q_i, dQ_i/dq_j and dQ_i/dq_j' at max_scalars i + j. null: not wanted; what
// the law does not read is not written.
struct SeveralOutputs {
  double* force[max_scalars]{};
  double* by_value[max_scalars * max_scalars]{};
  double* by_rate[max_scalars * max_scalars]{};
};

// Springs, or elements, of one group. Arrays are [count].
struct LawBatch {
  const Group& group;
  std::size_t count;
  RowSelection rows;
  const double* q;                // invariant: length (m), angle (rad), area (m^2), volume (m^3)
  const double* rate;             // dq/dt; may be null where no law of the group reads it
  const double* speed = nullptr;  // |dv|, m/s; may be null where no law of the group reads it
  InternalSelection internal{};
  const SeveralInputs* several = nullptr;  // in place of q, rate, speed
  CalledMembers members{};                 // for reports of crashes
};

// Where one law of a batch writes its answers, [count] each; null where they are not wanted.
struct LawOutputs {
  double* force = nullptr;  // null, and no margin nor other derivatives: the law is not evaluated
  double* by_q = nullptr;
  double* by_rate = nullptr;                // 0 for a law that does not read the rate
  double* energy = nullptr;                 // J; nan for a law without one
  double* margin = nullptr;                 // to rupture; infinity for a law that cannot rupture
  double* energy_by_q = nullptr;            // dE/dq; null for a law without an energy
  const SeveralOutputs* several = nullptr;  // in place of the force and its derivatives
  bool several_tangent = false;             // whether derivatives of several are wanted
  // [Jacobian of the law], see springnet_law_batch::derivatives; null: none of it is wanted. In place of the tangent of
  // several.
  double* const* derivatives = nullptr;
  // [parameter] dQ/d(parameter), each may be null, of a law without those; null: none is wanted.
  double* const* by_parameters = nullptr;
};
using PairOutputs = std::array<LawOutputs, 2>;  // as Group::laws()

// The derivatives that laws with SPRINGNET_HAS_ALL_DERIVATIVES give; in a step of internal states those of the step.
[[nodiscard]] inline sdk::JacobianLayout jacobian_of(const Law& law) noexcept {
  return {law.scalar_count > 0 ? law.scalar_count : 1, law.parameter_count, law.state_count, law.input_count};
}
[[nodiscard]] inline bool steps_states(const Law& law, const InternalView* view) noexcept {
  return law.state_count > 0 && view != nullptr && view->time_step > 0.0;
}

// Members of a law with internal state that are evaluated in one call.
inline constexpr std::size_t states_batch = 128;

// Evaluates one law with internal state on members [begin, begin + call.count) of a batch, count at most states_batch.
// `call` is complete but for the states; it may get other outputs. start_inputs: where a step starts, if there is one.
springnet_status evaluate_with_states(const InternalSelection& internal, const Law& law, std::size_t begin,
                                      const double* const* start_inputs, springnet_law_batch& call);

// Evaluates the laws of the batch's group, the spring function first; outputs of a law that the group does not have are
// left alone. Does not throw. Returns the status of the first law that failed, with a message that names it, its plugin
// and the reason; SPRINGNET_FAILED if derivatives are wanted of a law without.
springnet_status evaluate_laws(const LawBatch& batch, InstructionSet set, double time, const PairOutputs& out,
                               springnet_message& message);

// Memory for the answers of both laws to a batch of up to `capacity`: [law][member]. Not initialised.
template <std::size_t capacity>
struct PairAnswers {
  alignas(64) double force[2][capacity];
  double by_q[2][capacity];
  double by_rate[2][capacity];
  double energy[2][capacity];

  // Forces, and what else is wanted.
  [[nodiscard]] PairOutputs outputs(bool derivatives, bool energies) noexcept {
    PairOutputs out{};
    for (std::size_t k = 0; k < 2; ++k) {
      out[k].force = force[k];
      if (derivatives) {
        out[k].by_q = by_q[k];
        out[k].by_rate = by_rate[k];
      }
      if (energies) out[k].energy = energy[k];
    }
    return out;
  }
};

}  // namespace springnet::layers
