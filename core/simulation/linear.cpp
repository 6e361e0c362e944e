// Derivatives and linear systems on behalf of an integrator, and the motion that the constraints leave.

#include <algorithm>
#include <optional>

#include "constraints/vectors.hpp"
#include "simulation/engine.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {

springnet_status Engine::linearise(const springnet_evaluation& at) {
  linear_rows_ = rigid_.rows(*placement(at.time), at.position);
  project_known_ = false;
  const springnet_status status =
      linearisation_.update(at.time, node_arrays(at.position, at.velocity), external_at(at.time), message_);
  if (status != SPRINGNET_OK) return status;
  if (rigid_.any()) {
    if (const springnet_status rods = linearise_rigid(at); rods != SPRINGNET_OK) return rods;
  }
  return linearise_friction(at);
}

// The force in a rigid connection turns with it: like a spring of that tension without stiffness of its own,
// T / l (1 - n n^T). How T changes is the multipliers' business.
springnet_status Engine::linearise_rigid(const springnet_evaluation& at) {
  ReactionsAt reactions(*this, at.time, at.position, at.velocity);
  for (std::size_t c = 0; c < rigid_.cluster_count(); ++c) {
    if (const springnet_status status = reactions.know(static_cast<std::uint32_t>(c)); status != SPRINGNET_OK)
      return status;
  }
  const std::vector<double>& tension = reactions.tensions();
  for (std::size_t r = 0; r < rigid_.rods().size(); ++r) {
    const RigidConnections::Rod& rod = rigid_.rods()[r];
    const Vector3 n = (vector_at(at.position, rod.first) - vector_at(at.position, rod.second)).normalized();
    linearisation_.add_bond(rod.first, rod.second, tension[r] / rod.length * (Matrix3::Identity() - n * n.transpose()));
  }
  return SPRINGNET_OK;
}

// Friction turns with the slip: a = -mu N / m t(v), whose derivative is -mu N / m (1 - n n^T - t t^T) / |slip|. Stiff
// where the slip is slow, so that implicit methods need it; how N changes is left out.
springnet_status Engine::linearise_friction(const springnet_evaluation& at) {
  const std::shared_ptr<const Placement> now = placement(at.time);
  std::optional<ReactionsAt> reactions;
  for (const ConstraintRow& row : linear_rows_) {
    if (row.second != ConstraintRow::no_node) continue;
    const std::uint32_t k = row.first;
    const auto j = static_cast<std::size_t>(row.surface);
    const double mu = sliding_coefficient_of(contact_.surfaces()[j].friction());
    if (mu == 0.0 || contact_.slip_phase(k) != Contact::Slip::goes_on || contact_.now(k).second >= 0) continue;
    Vector3 reaction;
    if (!reactions) reactions.emplace(*this, at.time, at.position, at.velocity);
    if (const springnet_status status = reactions->of(k, reaction); status != SPRINGNET_OK) return status;
    const Vector3 n = row.direction;
    const Vector3 slip = contact_.slip_vector(*now, k, j, vector_at(at.position, k), vector_at(at.velocity, k));
    const double strength = mu * std::max(0.0, n.dot(reaction)) / mass_[k];
    linearisation_.add_to_velocity_block(k, friction_by_velocity(strength, slip, n));
  }
  return SPRINGNET_OK;
}

springnet_status Engine::jacobian_times(const double* dp, const double* dv, double* out) {
  linearisation_.times(dp, dv, out);
  return linear_rows_.empty() ? SPRINGNET_OK : project(nullptr, out);
}

springnet_status Engine::factorise(double velocity_weight, double position_weight) {
  return linearisation_.factorise(velocity_weight, position_weight, linear_rows_, message_);
}

springnet_status Engine::project(const double* mobility, double* values) {
  const std::size_t n = layout_.node_count();
  for (std::size_t k = 0; k < n; ++k) {
    if (contact_.constrained()[k] == 0) continue;
    for (std::size_t c = 0; c < 3; ++c) values[c * n + k] = 0.0;
  }
  if (linear_rows_.empty()) return SPRINGNET_OK;
  const std::size_t wanted = mobility == nullptr ? 0 : 9 * n;
  const bool same = project_known_ && project_mobility_.size() == wanted &&
                    std::equal(project_mobility_.begin(), project_mobility_.end(), mobility);
  if (!same) {
    if (mobility == nullptr) {
      project_mobility_.clear();
      project_system_.set(linear_rows_, [this](std::uint32_t node) { return rigid_.mobility(node); });
    } else {
      project_mobility_.assign(mobility, mobility + wanted);
      project_system_.set(linear_rows_, [&](std::uint32_t node) -> Eigen::Matrix3d {
        if (contact_.constrained()[node] != 0) return Eigen::Matrix3d::Zero();
        return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(mobility + 9 * std::size_t{node});
      });
    }
    project_known_ = true;
  }
  const auto at = [&](std::uint32_t k) { return Vector3(values[k], values[n + k], values[2 * n + k]); };
  Eigen::VectorXd rate(static_cast<Eigen::Index>(linear_rows_.size()));
  for (std::size_t r = 0; r < linear_rows_.size(); ++r) {
    const ConstraintRow& row = linear_rows_[r];
    Vector3 relative = at(row.first);
    if (row.second != ConstraintRow::no_node) relative -= at(row.second);
    rate[static_cast<Eigen::Index>(r)] = row.direction.dot(relative);
  }
  project_system_.for_each_change(project_system_.solve(-rate), [&](std::uint32_t node, const Vector3& change) {
    for (std::size_t c = 0; c < 3; ++c) values[c * n + node] += change[static_cast<Eigen::Index>(c)];
  });
  return SPRINGNET_OK;
}

springnet_status Engine::project_state(double time, const springnet_vectors& position,
                                       const springnet_vectors& velocity) {
  const std::shared_ptr<const Placement> now = placement(time);
  const springnet_vectors& start = state_.view.position;
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    const Touch& touch = contact_.now(k);
    if (contact_.fixed()[k] != 0) {
      const bool moves = contact_.prescribed().moves(k);
      put_vector(position, k, moves ? contact_.prescribed().position(now->motions, k) : vector_at(start, k));
      put_vector(velocity, k, moves ? contact_.prescribed().velocity(now->motions, k) : Vector3::Zero());
    } else if (touch.surface >= 0 && !touch.slides) {
      const Vector3 place = contact_.carried(*now, vector_at(start, k), touch.surface);
      put_vector(position, k, place);
      put_vector(velocity, k, Contact::velocity(*now, static_cast<std::size_t>(touch.surface), place));
    }
  }
  return rigid_.project(*now, position, velocity, message_);
}

}  // namespace springnet
