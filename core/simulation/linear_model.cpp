#include "simulation/linear_model.hpp"

#include <optional>

#include "simulation/linear_sweep.hpp"
#include "simulation/reactions_at.hpp"

namespace springnet {

LinearModel::LinearModel(Model& model)
    : model_(model), blocks_(model.layout, model.evaluator, model.contact.constrained()) {}

LinearModel::~LinearModel() = default;

springnet_status LinearModel::linearise(const springnet_evaluation& at) {
  sweep_.reset();
  model_.constraints.linearise(*model_.placement(at.time), at.position);
  const springnet_status status = blocks_.update(at.time, node_arrays(at.position, at.velocity),
                                                 model_.external_at(at.time), model_.journal.message);
  return status == SPRINGNET_OK ? add_constraints(at) : status;
}

springnet_status LinearModel::add_constraints(const springnet_evaluation& at) {
  const ConstraintSet& constraints = model_.constraints;
  std::optional<ReactionsAt> reactions;
  const auto known = [&]() -> ReactionsAt& {
    return reactions ? *reactions : reactions.emplace(model_, at.time, at.position, at.velocity);
  };
  for (std::uint32_t c = 0; c < model_.rigid.cluster_count(); ++c)
    if (const springnet_status status = known().know(c); status != SPRINGNET_OK) return status;
  for (std::size_t r = 0; r < model_.rigid.rods().size(); ++r) {
    const RigidConnections::Rod& rod = model_.rigid.rods()[r];
    blocks_.add_bond(rod.first, rod.second, constraints.rod_geometric_stiffness(r, at.position, known().tensions()[r]));
  }
  for (const ConstraintRow& row : constraints.rows()) {
    if (!constraints.friction_follows_slip(row)) continue;
    Vector3 reaction;
    if (const springnet_status status = known().of(row.first, reaction); status != SPRINGNET_OK) return status;
    blocks_.add_to_velocity_block(
        row.first, constraints.friction_derivative(known().placement(), row, at.position, at.velocity, reaction));
  }
  return SPRINGNET_OK;
}

springnet_status LinearModel::times(const double* dp, const double* dv, double* out) {
  blocks_.times(dp, dv, out);
  return model_.constraints.rows().empty() ? SPRINGNET_OK : project(nullptr, out);
}

void LinearModel::diagonal_blocks(double velocity_weight, double position_weight, double* out) const {
  blocks_.diagonal_blocks(velocity_weight, position_weight, out);
}

springnet_status LinearModel::factorise(double velocity_weight, double position_weight) {
  return blocks_.factorise(velocity_weight, position_weight, model_.constraints.rows(), model_.journal.message);
}

springnet_status LinearModel::solve(bool transposed, const double* right_side, double* x) {
  return blocks_.solve(transposed, right_side, x, model_.journal.message);
}

springnet_status LinearModel::sweep(const springnet_sweep& request, const springnet_network& network) {
  const springnet_sweep sweep = complete(request);
  order_check_.check(sweep, network);
  if (!sweep_) sweep_ = std::make_unique<LinearSweep>(blocks_, model_.constraints, model_.mass);
  struct Updating {
    bool& flag;
    ~Updating() { flag = false; }
  } const updating{model_.in_callback};
  model_.in_callback = true;
  sweep_->run(sweep);
  return SPRINGNET_OK;
}

springnet_status LinearModel::project(const double* mobility, double* values) {
  model_.constraints.project_change(mobility, values);
  return SPRINGNET_OK;
}

}  // namespace springnet
