#include "simulation/linear_model.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "plugin_host/message.hpp"

#include "layers/linear/thinness.hpp"
#include "simulation/linear_sweep.hpp"
#include "simulation/reactions_at.hpp"
#include "simulation/rows_aside.hpp"

namespace springnet {
namespace {

// Conjugate gradients are used up to this asymmetry of the matrix, in units of the accuracy asked for.
constexpr double symmetric_share = 1.0;
// More may not be left out of an approximate system.
constexpr double max_asymmetry = 0.05;
// Iterations before a factorisation is tried, for nets of up to so many nodes, and the most without one. Factors of
// solids fill up: there they take as long as many iterations.
constexpr std::uint32_t patience = 100, max_solver_iterations = 400;
constexpr std::size_t max_nodes_factorised = 3000;
// From here on matrices are larger than the caches. Smaller nets are solved without one only if they are solids, for
// which the preconditioner of the nodes' own blocks is good.
constexpr std::size_t nodes_worth_no_matrix = 2000;

// Without outputs, which are for evaluations.
layers::InternalView quiet(layers::InternalView view) {
  view.next = view.rates = nullptr;
  return view;
}

}  // namespace

LinearModel::LinearModel(Model& model)
    : model_(model),
      blocks_(model.layout, model.evaluator, model.contact.constrained()),
      elimination_(model.layout, model.evaluator.instruction_set()),
      system_(model.layout, model.mass, model.contact.constrained(), model.evaluator.threads()),
      solver_(model.evaluator.instruction_set(), model.evaluator.threads()),
      matrix_free_(model.layout, model.evaluator, model.mass, model.contact.constrained()) {
  solver_.set_deadline(&model.deadline);
  matrix_free_.set_deadline(&model.deadline);
}

LinearModel::~LinearModel() = default;

void LinearModel::forget() noexcept {
  sweep_.reset();
  last_response_ = &response_;
  at_hand_ = indefinite_ = false;
  topology_changed();
}

springnet_status LinearModel::linearise(const springnet_evaluation& at, double elimination, double of_step) {
  sweep_.reset();
  response_.forget();
  last_response_ = &response_;
  at_hand_ = false;
  const std::size_t n = model_.mass.size();
  linearised_at_.resize(3 * n);
  const double* const position[] = {at.position.x, at.position.y, at.position.z};
  for (std::size_t c = 0; c < 3; ++c) std::copy_n(position[c], n, linearised_at_.data() + c * n);
  if (factors_.owner == Factors::Owner::system) factors_.owner = Factors::Owner::nobody;
  factors_.current = false;
  model_.constraints.linearise(*model_.placement(at.time), at.position);
  layers::InternalView internal = quiet(model_.internal_for(at.internal));
  elimination_.forget();
  if (elimination > 0.0 && internal.time_step == 0.0 && model_.layout.internal().any())
    elimination_.begin(node_arrays(at.position, at.velocity, internal), elimination, internal);
  const springnet_status status = blocks_.update(at.time, node_arrays(at.position, at.velocity, internal),
                                                 model_.external_at(at.time), model_.journal.message);
  return status == SPRINGNET_OK ? add_constraints(at, of_step) : status;
}

springnet_status LinearModel::add_constraints(const springnet_evaluation& at, double of_step) {
  const ConstraintSet& constraints = model_.constraints;
  std::optional<ReactionsAt> reactions;
  const auto known = [&]() -> ReactionsAt& {
    if (reactions) return *reactions;
    return reactions.emplace(model_, at.time, at.position, at.velocity, quiet(model_.internal_for(at.internal)));
  };
  for (std::uint32_t c = 0; c < model_.rigid.cluster_count(); ++c)
    if (const springnet_status status = known().know(c); status != SPRINGNET_OK) return status;
  for (std::size_t r = 0; r < model_.rigid.rods().size(); ++r) {
    const RigidConnections::Rod& rod = model_.rigid.rods()[r];
    blocks_.add_bond(rod.first, rod.second, constraints.rod_geometric_stiffness(r, at.position, known().tensions()[r]));
  }
  if (constraints.bodies().located())
    if (const springnet_status status = add_drags(known()); status != SPRINGNET_OK) return status;
  if (constraints.rows().empty()) return SPRINGNET_OK;
  // Impulses of a step turn friction, whatever the damping: it does not limit explicit steps.
  if (of_step > 0.0)
    for (const BodyPushes::Drag& drag : constraints.pushes().drags()) blocks_.add_drag(drag.row, drag.damping);
  return find_response(at, of_step, known(), response_, [this](const ConstraintRow& row, const Matrix3& derivative) {
    blocks_.add_to_velocity_block(row.first, derivative);
  });
}

// Friction of bodies that slide turns with the slip.
springnet_status LinearModel::add_drags(ReactionsAt& reactions) {
  const BodyContacts& bodies = model_.constraints.bodies();
  const BodyMotion* motion = nullptr;
  const springnet_status status = reactions.bodies(motion);
  if (motion == nullptr) return status;
  for (std::size_t i = 0; i < motion->pairs().size(); ++i) {
    const PairTouch& touch = bodies.touching()[i];
    const BodyMotion::OfPair& pair = motion->pairs()[i];
    const double mu = sliding_coefficient_of(bodies.law_of(touch.kind, touch.pair).friction);
    const Vector3 slip = pair.motion.slip();
    const double speed = slip.norm();
    if (touch.sticks || touch.phase != Contact::Slip::ongoing || !(mu * pair.pressing > 0.0) || speed == 0.0) continue;
    const Vector3 across = pair.motion.normal.cross(slip / speed);
    blocks_.add_drag(row_along(pair.motion, across), mu * pair.pressing / speed);
  }
  return SPRINGNET_OK;
}

template <class Use>
springnet_status LinearModel::find_response(const springnet_evaluation& at, double of_step, ReactionsAt& reactions,
                                            ConstrainedResponse& response, const Use& use) {
  const ConstraintSet& constraints = model_.constraints;
  std::vector<std::uint32_t> sliding;
  for (const ConstraintRow& row : constraints.rows())
    if (row.surface >= 0) sliding.push_back(row.first);  // ascending
  sliding.erase(std::unique(sliding.begin(), sliding.end()), sliding.end());
  if (const springnet_status status = reactions.prepare(std::move(sliding)); status != SPRINGNET_OK) return status;
  if (const springnet_status status = response.find(model_, reactions); status != SPRINGNET_OK) return status;
  for (const ConstraintRow& row : constraints.rows()) {
    if (!constraints.friction_follows_slip(row)) continue;
    Vector3 reaction = Vector3::Zero();
    if (of_step > 0.0 && !model_.rigid.any()) reaction = model_.contact.sweep_impulse(row.first) / of_step;
    if (reaction.isZero(0.0))
      if (const springnet_status status = reactions.of(row.first, reaction); status != SPRINGNET_OK) return status;
    use(row, constraints.friction_derivative(reactions.placement(), row, at.position, at.velocity, reaction));
  }
  return SPRINGNET_OK;
}

springnet_status LinearModel::change_internal(const springnet_internal_change& request) {
  if (!elimination_.known()) {
    set_message(model_.journal.message, "change_internal was called without an elimination of internal states");
    return SPRINGNET_FAILED;
  }
  internal_change_.resize(model_.layout.internal().count());
  double* const change = request.change != nullptr ? request.change : internal_change_.data();
  elimination_.change(request.right_side, request.dp, request.dv, change);
  if (request.acceleration == nullptr) return SPRINGNET_OK;
  const std::size_t n = model_.mass.size();
  internal_force_.assign(3 * n, 0.0);
  elimination_.add_forces(change, internal_force_.data());
  blocks_.accelerations(internal_force_.data(), request.acceleration);
  return model_.constraints.rows().empty() ? SPRINGNET_OK : project(nullptr, request.acceleration);
}

springnet_status LinearModel::times(const double* dp, const double* dv, bool true_friction, double* out) {
  blocks_.times(dp, dv, out);
  if (!true_friction || !response_.known())
    return model_.constraints.rows().empty() ? SPRINGNET_OK : project(nullptr, out);
  response_.add_forces(dp, out);
  response_.apply(false, out);
  response_.add_rates(dp, dv, out);
  clear_held(out);
  return SPRINGNET_OK;
}

springnet_status LinearModel::transposed_times(const double* weights, bool true_friction, double* by_position,
                                               double* by_velocity) {
  weights_of_free_.assign(weights, weights + 3 * model_.mass.size());
  double* const own = weights_of_free_.data();
  clear_held(own);
  const bool responds = true_friction && response_.known();
  if (responds)
    response_.apply(true, own);
  else
    model_.constraints.project_change(nullptr, own, true);
  blocks_.transposed_times(own, by_position, by_velocity);
  if (!responds) return SPRINGNET_OK;
  response_.add_forces_transposed(own, by_position);
  weights_of_free_.assign(weights, weights + 3 * model_.mass.size());
  clear_held(own);
  response_.add_rates_transposed(own, by_position, by_velocity);
  return SPRINGNET_OK;
}

// Fixed and held nodes do not answer.
void LinearModel::clear_held(double* values) const {
  const std::size_t n = model_.mass.size();
  for (std::size_t k = 0; k < n; ++k)
    if (model_.contact.constrained()[k] != 0)
      for (std::size_t c = 0; c < 3; ++c) values[c * n + k] = 0.0;
}

void LinearModel::project_accelerations(bool transposed, double* values) {
  if (last_response_->known())
    last_response_->apply(transposed, values);
  else if (last_response_ == &matrix_free_response_)
    clear_held(values);  // no node slides
  else
    model_.constraints.project_change(nullptr, values, transposed);
}

void LinearModel::weighted_transposed_times(double velocity_weight, double position_weight, const double* weights,
                                            double* out) {
  if (!model_.constraints.rows().empty()) {
    weights_of_free_.assign(weights, weights + 3 * model_.mass.size());
    clear_held(weights_of_free_.data());
    model_.constraints.project_change(nullptr, weights_of_free_.data(), true);
    weights = weights_of_free_.data();
  }
  blocks_.weighted_transposed_times(velocity_weight, position_weight, weights, out);
}

void LinearModel::diagonal_blocks(double velocity_weight, double position_weight, double* out) {
  blocks_.diagonal_blocks(velocity_weight, position_weight, out);
}

springnet_status LinearModel::factorise(double velocity_weight, double position_weight) {
  const springnet_status status = factorise_for(Factors::Owner::integrator, velocity_weight, position_weight);
  if (status == SPRINGNET_OK) factors_ = {Factors::Owner::integrator, velocity_weight, position_weight, true};
  return status;
}

springnet_status LinearModel::factorise_for(Factors::Owner owner, double velocity_weight, double position_weight) {
  factors_.owner = Factors::Owner::nobody;
  const springnet_status status =
      blocks_.factorise(velocity_weight, position_weight, model_.constraints.rows(), model_.journal.message);
  if (status == SPRINGNET_OK) factors_.owner = owner;
  return status;
}

springnet_status LinearModel::solve(bool transposed, const double* right_side, double* x) {
  if (factors_.owner != Factors::Owner::integrator && factors_.current) {  // a prepared system took their place
    const springnet_status status =
        factorise_for(Factors::Owner::integrator, factors_.velocity_weight, factors_.position_weight);
    if (status != SPRINGNET_OK) return status;
  }
  if (factors_.owner != Factors::Owner::integrator) {
    set_message(model_.journal.message, "solve was called without a factorisation");
    return SPRINGNET_FAILED;
  }
  return blocks_.solve(transposed, right_side, x, model_.journal.message);
}

springnet_status LinearModel::prepare(const springnet_linear_system& request) {
  const layers::FlushDenormals flush;
  const layers::SystemWeights weights{request.velocity_weight, request.position_weight, request.shift};
  if (request.at != nullptr) {
    if (request.exact == 0 && prepare_matrix_free(*request.at, weights)) return SPRINGNET_OK;
    if (request.exact == 0 && assembled_next_ > 0) --assembled_next_;
    begin_system(weights);
    if (const springnet_status status = linearise(*request.at, 0.0, weights.velocity); status != SPRINGNET_OK)
      return status;
  }
  begin_system(weights);
  assemble();
  return SPRINGNET_OK;
}

void LinearModel::begin_system(const layers::SystemWeights& weights) {
  prepared_ = Prepared::nothing;
  last_response_ = &response_;
  indefinite_ = false;
  if (factors_.owner == Factors::Owner::system) factors_.owner = Factors::Owner::nobody;
  weights_ = weights;
}

bool LinearModel::prepare_matrix_free(const springnet_evaluation& at, const layers::SystemWeights& weights,
                                      const std::vector<layers::NodeResponse>* responses) {
  const layers::FlushDenormals flush;
  begin_system(weights);
  const layers::InternalView internal = quiet(model_.internal_for(at.internal));
  if (!may_be_matrix_free(at, weights)) return false;
  if (responses != nullptr && !responses->empty()) {
    if (!node_responses_.empty()) return false;
    node_responses_ = *responses;
  }
  if (!matrix_free_.prepare(at.time, node_arrays(at.position, at.velocity, internal), model_.external_at(at.time),
                            weights_, node_responses_) ||
      !(matrix_free_.asymmetry() <= max_asymmetry))
    return false;
  prepared_ = Prepared::matrix_free;
  at_hand_ = false;
  last_response_ = &matrix_free_response_;
  keep_state(at);
  return true;
}

bool LinearModel::may_be_matrix_free(const springnet_evaluation& at, const layers::SystemWeights& weights) {
  if (assembled_next_ > 0 || !suits_matrix_free() || !matrix_free_.fits() || model_.rigid.any()) return false;
  node_responses_.clear();
  matrix_free_response_.forget();
  const RowsAside aside(model_.constraints);
  model_.constraints.linearise(*model_.placement(at.time), at.position);
  const std::vector<ConstraintRow>& rows = model_.constraints.rows();
  if (rows.empty()) return true;
  if (std::any_of(rows.begin(), rows.end(), [](const ConstraintRow& row) { return row.is_pair; })) return false;
  ReactionsAt reactions(model_, at.time, at.position, at.velocity, quiet(model_.internal_for(at.internal)));
  std::vector<std::pair<std::uint32_t, Matrix3>> slips;
  if (find_response(at, weights.velocity, reactions, matrix_free_response_,
                    [&](const ConstraintRow& row, const Matrix3& derivative) {
                      slips.emplace_back(row.first, derivative);
                    }) != SPRINGNET_OK ||
      (holds_friction_ && matrix_free_response_.has_friction()))
    return false;
  auto next = slips.begin();
  matrix_free_response_.for_each_lone([&](std::uint32_t node, const Matrix3& response) {
    layers::NodeResponse& own = node_responses_.emplace_back();
    own = {node, response, Matrix3::Zero()};
    for (; next != slips.end() && next->first == node; ++next) own.by_velocity += next->second;
  });
  return true;
}

bool LinearModel::suits_matrix_free() { return model_.mass.size() >= nodes_worth_no_matrix || !is_thin(); }

bool LinearModel::is_thin() {
  if (!thin_) thin_ = layers::is_thin(model_.layout);
  return *thin_;
}

void LinearModel::keep_state(const springnet_evaluation& at) {
  const std::size_t n = model_.mass.size();
  kept_time_ = at.time;
  kept_state_.resize(6 * n);
  const double* const from[] = {at.position.x, at.position.y, at.position.z,
                                at.velocity.x, at.velocity.y, at.velocity.z};
  for (std::size_t c = 0; c < 6; ++c) std::copy_n(from[c], n, kept_state_.data() + c * n);
  kept_internal_ = {};
  if (at.internal != nullptr) kept_internal_ = *at.internal;
}

springnet_status LinearModel::assemble_kept() {
  const std::size_t n = model_.mass.size();
  const double* const state = kept_state_.data();
  springnet_evaluation at{};
  at.struct_size = sizeof at;
  at.time = kept_time_;
  at.position = {state, state + n, state + 2 * n};
  at.velocity = {state + 3 * n, state + 4 * n, state + 5 * n};
  if (kept_internal_.struct_size > 0) at.internal = &kept_internal_;
  const springnet_status status = linearise(at, 0.0, weights_.velocity);
  if (status == SPRINGNET_OK) assemble();
  return status;
}

void LinearModel::assemble() {
  using Kind = layers::BlockPreconditioner::Kind;
  system_.assemble(blocks_, weights_);
  const bool rows = !model_.constraints.rows().empty();
  const double* const at = linearised_at_.data();
  const std::size_t n = model_.mass.size();
  solver_.prepare(system_, is_thin() ? Kind::factors : Kind::blocks, {at, at + n, at + 2 * n},
                  [&](const std::vector<double>& mobility) {
                    layers::Projection made = rows ? model_.constraints.projection(mobility) : layers::Projection();
                    if (has_friction()) made.reactions = [this](double* forces) { response_.take_reactions(forces); };
                    return made;
                  });
  right_side_.assign(3 * model_.mass.size() + 1, 0.0);
  solution_.assign(3 * model_.mass.size() + 1, 0.0);
  prepared_ = Prepared::assembled;
  at_hand_ = true;
}

springnet_status LinearModel::solve_prepared(springnet_linear_solve& request) {
  if (prepared_ == Prepared::nothing) {
    set_message(model_.journal.message, "solve_system was called without a prepared system");
    return SPRINGNET_FAILED;
  }
  const std::size_t n = model_.mass.size();
  const auto answered = [&](const layers::SolveAnswer& answer) {
    request.iterations = answer.iterations;
    request.residual = answer.residual;
    request.outcome = answer.outcome == layers::SolveOutcome::solved      ? SPRINGNET_SOLVED
                      : answer.outcome == layers::SolveOutcome::truncated ? SPRINGNET_TRUNCATED
                                                                          : SPRINGNET_STALLED;
  };
  const double* b = request.right_side;
  std::uint64_t iterations_before = 0;
  if (prepared_ == Prepared::matrix_free) {
    kept_right_side_.assign(b, b + 3 * n);  // x may be that
    answered(matrix_free_.solve(request.accuracy, max_solver_iterations, b, request.x));
    if (request.outcome == SPRINGNET_STALLED && !model_.deadline.has_passed() &&
        matrix_free_.renews({kept_state_.data(), kept_state_.data() + n, kept_state_.data() + 2 * n})) {
      iterations_before = request.iterations;
      b = kept_right_side_.data();
      answered(matrix_free_.solve(request.accuracy, max_solver_iterations, b, request.x));
      request.iterations += iterations_before;
    }
    if (request.outcome == SPRINGNET_SOLVED) assembled_after_stall_ = least_assembled;
    if (request.outcome != SPRINGNET_STALLED || model_.deadline.has_passed()) return SPRINGNET_OK;
    assembled_next_ = assembled_after_stall_;
    assembled_after_stall_ = std::min(2 * assembled_after_stall_, most_assembled);
    iterations_before = request.iterations;
    b = kept_right_side_.data();
    if (const springnet_status status = assemble_kept(); status != SPRINGNET_OK) return status;
  }
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t c = 0; c < 3; ++c)
      right_side_[3 * k + c] = model_.contact.constrained()[k] != 0 ? 0.0 : model_.mass[k] * b[c * n + k];
  const bool may_factorise = at_hand_ && n <= max_nodes_factorised;
  if (may_factorise && factors_.owner == Factors::Owner::system) return solve_directly(request, b);
  // Conjugate gradients where the matrix is as good as symmetric, for the accuracy asked for.
  const bool symmetric = !indefinite_ && !has_friction() && system_.asymmetry() <= symmetric_share * request.accuracy;
  const auto solve = [&](bool by_conjugate_gradients) {
    return solver_.solve(system_, by_conjugate_gradients, request.accuracy,
                         may_factorise && is_thin() ? patience : max_solver_iterations, right_side_, solution_);
  };
  layers::SolveAnswer answer = solve(symmetric);
  if (answer.outcome == layers::SolveOutcome::truncated) {
    // As with a sheet under compression: the step may still have one solution, to which the whole matrix leads.
    indefinite_ = true;
    answer = solve(false);
  }
  answered(answer);
  request.iterations += iterations_before;
  if (request.outcome == SPRINGNET_STALLED && may_factorise && !model_.deadline.has_passed())
    return solve_directly(request, b);
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t c = 0; c < 3; ++c) request.x[c * n + k] = solution_[3 * k + c];
  return SPRINGNET_OK;
}

springnet_status LinearModel::solve_directly(springnet_linear_solve& request, const double* b) {
  // (1 + shift) A with weights that are smaller by 1 + shift: of the form that factorise() knows.
  const double scale = 1.0 / (1.0 + weights_.shift);
  if (factors_.owner != Factors::Owner::system)
    if (const springnet_status status =
            factorise_for(Factors::Owner::system, scale * weights_.velocity, scale * weights_.position);
        status != SPRINGNET_OK)
      return status;
  const std::size_t n = model_.mass.size();
  std::vector<double> right_side(3 * n);
  for (std::size_t i = 0; i < 3 * n; ++i) right_side[i] = model_.contact.constrained()[i % n] != 0 ? 0.0 : scale * b[i];
  // What constraints do not allow of it would come back in the solution: see Linearisation::solve.
  if (!model_.constraints.rows().empty())
    if (const springnet_status status = project(nullptr, right_side.data()); status != SPRINGNET_OK) return status;
  const springnet_status status = blocks_.solve(false, right_side.data(), request.x, model_.journal.message);
  if (status != SPRINGNET_OK) return status;
  const bool finite = std::all_of(request.x, request.x + 3 * n, [](double x) { return std::isfinite(x); });
  request.outcome = finite ? SPRINGNET_SOLVED : SPRINGNET_STALLED;
  request.residual = finite ? 0.0 : 1.0;
  request.iterations = 0;
  return SPRINGNET_OK;
}

springnet_status LinearModel::rows(springnet_system_rows& out) {
  if (prepared_ == Prepared::nothing) {
    set_message(model_.journal.message, "system_rows was called without a prepared system");
    return SPRINGNET_FAILED;
  }
  if (prepared_ == Prepared::matrix_free)
    if (const springnet_status status = assemble_kept(); status != SPRINGNET_OK) return status;
  const layers::BlockArrays arrays = system_.arrays();
  out.row_start = arrays.start;
  out.columns = arrays.column;
  out.blocks = arrays.values;
  low_rank_start_.assign(1, 0);
  low_rank_nodes_.clear();
  low_rank_g_.clear();
  low_rank_w_.clear();
  for (const layers::BlockSystem::RankOne& term : system_.terms()) {
    for (std::size_t i = 0; i < term.nodes.size(); ++i) {
      low_rank_nodes_.push_back(term.nodes[i]);
      low_rank_g_.insert(low_rank_g_.end(), term.g[i].data(), term.g[i].data() + 3);
      low_rank_w_.insert(low_rank_w_.end(), term.w[i].data(), term.w[i].data() + 3);
    }
    low_rank_start_.push_back(low_rank_nodes_.size());
  }
  out.low_rank_count = static_cast<std::uint32_t>(low_rank_start_.size() - 1);
  out.low_rank_start = low_rank_start_.data();
  out.low_rank_nodes = low_rank_nodes_.data();
  out.low_rank_g = low_rank_g_.data();
  out.low_rank_w = low_rank_w_.data();
  return SPRINGNET_OK;
}

springnet_status LinearModel::sweep(const springnet_sweep& request, const springnet_network& network) {
  const springnet_sweep sweep = complete(request);
  order_check_.check(sweep, network, model_.layout);
  if (!sweep_) sweep_ = std::make_unique<LinearSweep>(blocks_, model_.constraints, model_.mass);
  struct Updating {
    bool& flag;
    ~Updating() { flag = false; }
  } const updating{model_.in_callback};
  model_.in_callback = true;
  sweep_->run(sweep);
  return SPRINGNET_OK;
}

springnet_status LinearModel::project(const double* mobility, double* values, bool transposed) {
  model_.constraints.project_change(mobility, values, transposed);
  return SPRINGNET_OK;
}

}  // namespace springnet
