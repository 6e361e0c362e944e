// Derivatives and linear systems on behalf of an integrator, and the motion that the constraints leave.

#include <optional>

#include "constraints/vectors.hpp"
#include "simulation/engine.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {

springnet_status Engine::linearise(const springnet_evaluation& at) {
  linear_sweep_.reset();
  constraints_.linearise(*placement(at.time), at.position);
  const springnet_status status =
      linearisation_.update(at.time, node_arrays(at.position, at.velocity), external_at(at.time), message_);
  return status == SPRINGNET_OK ? linearise_constraints(at) : status;
}

// Implicit methods need what rigid connections and friction add, because it is stiff where tensions are great and slips
// slow.
springnet_status Engine::linearise_constraints(const springnet_evaluation& at) {
  std::optional<ReactionsAt> reactions;
  const auto known = [&]() -> ReactionsAt& {
    return reactions ? *reactions : reactions.emplace(*this, at.time, at.position, at.velocity);
  };
  for (std::uint32_t c = 0; c < rigid_.cluster_count(); ++c)
    if (const springnet_status status = known().know(c); status != SPRINGNET_OK) return status;
  for (std::size_t r = 0; r < rigid_.rods().size(); ++r)
    linearisation_.add_bond(rigid_.rods()[r].first, rigid_.rods()[r].second,
                            constraints_.turning_of(r, at.position, known().tensions()[r]));
  for (const ConstraintRow& row : constraints_.rows()) {
    if (!constraints_.friction_follows_slip(row)) continue;
    Vector3 reaction;
    if (const springnet_status status = known().of(row.first, reaction); status != SPRINGNET_OK) return status;
    linearisation_.add_to_velocity_block(
        row.first, constraints_.friction_of(known().placement(), row, at.position, at.velocity, reaction));
  }
  return SPRINGNET_OK;
}

springnet_status Engine::jacobian_times(const double* dp, const double* dv, double* out) {
  linearisation_.times(dp, dv, out);
  return constraints_.rows().empty() ? SPRINGNET_OK : project(nullptr, out);
}

springnet_status Engine::factorise(double velocity_weight, double position_weight) {
  return linearisation_.factorise(velocity_weight, position_weight, constraints_.rows(), message_);
}

springnet_status Engine::project(const double* mobility, double* values) {
  constraints_.project_change(mobility, values);
  return SPRINGNET_OK;
}

springnet_status Engine::project_state(double time, const springnet_vectors& position,
                                       const springnet_vectors& velocity) {
  const std::shared_ptr<const Placement> now = placement(time);
  constraints_.place(*now, read_only(state_.view.position), position, velocity);
  return constraints_.project(*now, position, velocity, message_);
}

}  // namespace springnet
