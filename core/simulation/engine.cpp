#include "simulation/engine.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"
#include "profile/stage.hpp"
#include "simulation/local_force.hpp"
#include "simulation/pair_forces.hpp"
#include "simulation/parameter_model.hpp"
#include "simulation/start.hpp"
#include "simulation/verlet_contact.hpp"

namespace springnet {

namespace {

// What holds a node bears the forces of other bodies on it, too: all of them, or along the obstacles that it slides on
// their normal parts. Those of nodes with rigid connections are known already.
void add_body_forces(const Model& model, const std::vector<Vector3>& of_pairs, Reactions& reactions) {
  const BodyContacts& bodies = model.constraints.bodies();
  if (bodies.touching().empty() || bodies.located()) return;  // located: ReactionsAt knows them
  const springnet_const_vectors p = read_only(model.state.view.position);
  const std::shared_ptr<const Placement> now = model.placement_now();
  for_each_body_force(model, of_pairs, [&](std::uint32_t k, const Vector3& force) {
    if (model.rigid.is_joined(k)) return;
    const Touch of = model.contact.committed(k);
    if (model.contact.fixed()[k] != 0 || (of.surface >= 0 && !of.slides))
      reactions.node[k] -= force;
    else if (of.surface >= 0)
      reactions.node[k] -= force - split_reaction(model.contact.normals(*now, k, vector_at(p, k)), force).tangential;
  });
}

}  // namespace

Engine::Engine(const Network& network, const PluginHost& plugins, const SimulationOptions& options,
               const Engine* before)
    : model_(network, plugins, options, before != nullptr ? &before->model_ : nullptr),
      linear_(model_),
      topology_(model_, linear_, network.cuts()),
      contact_events_(model_, topology_),
      info_(model_, contact_events_),
      calls_(model_),
      sweep_(model_),
      ledger_(model_),
      changes_(*this, network.changes()) {
  if (options.dissipated_energy) dissipation_ = std::make_unique<DissipationLedger>();
  if (before != nullptr) {
    take_over(*before, network);
    return;
  }
  topology_.perform_due_cuts();
  if (topology_.perform_due_ruptures() != SPRINGNET_OK) throw Error(ErrorKind::simulation, model_.journal.message.text);
  model_.scales = find_scales(model_);
  start_constraints(model_, size_of(network));
  check_apart(network);
  changes_.perform_due();
}

Engine::Engine(const Engine& other, const Network& network, const SimulationOptions& options)
    : model_(other.model_, network, options),
      linear_(model_),
      topology_(model_, linear_, network.cuts()),
      contact_events_(model_, topology_),
      info_(model_, contact_events_),
      calls_(model_),
      sweep_(model_),
      ledger_(model_),
      changes_(*this, network.changes()) {
  if (options.dissipated_energy) dissipation_ = std::make_unique<DissipationLedger>();
}

Engine::~Engine() = default;

void Engine::laws_changed() {
  model_.layout.settle_changes();
  linear_.topology_changed();
  local_force_.reset();
  model_.changed();
}

ParameterModel& Engine::parameters() {
  if (!parameters_) parameters_ = std::make_unique<ParameterModel>(model_);
  return *parameters_;
}

LocalForceModel& Engine::local_force() {
  if (!local_force_) local_force_ = std::make_unique<LocalForceModel>(model_);
  return *local_force_;
}

const std::vector<Vector3>& Engine::pair_forces() {
  // A step that fails may leave other pairs.
  if (model_.stale.pair_forces || pair_forces_.size() != model_.constraints.bodies().touching().size()) {
    const profile::Stage stage("reactions");
    pair_forces_ = smallest_pair_forces(model_);
    model_.stale.pair_forces = false;
  }
  return pair_forces_;
}

const Reactions& Engine::reactions() {
  if (model_.stale.reactions) {
    const profile::Stage stage("reactions");
    reactions_ = reactions_now(model_, pair_forces());
    add_body_forces(model_, pair_forces(), reactions_);
    model_.stale.reactions = false;
  }
  return reactions_;
}

Vector3 Engine::reaction_of(std::uint32_t node, std::size_t surface) {
  return model_.constraints.share_of(*model_.placement(model_.time), node, surface,
                                     vector_at(model_.state.view.position, node), reactions().node[node]);
}

double Engine::dissipated_energy() const noexcept {
  return dissipation_ ? dissipation_->total() : std::numeric_limits<double>::quiet_NaN();
}

double Engine::potential_energy() {
  const profile::Stage stage("energy");
  const layers::NodeArrays nodes = model_.state.nodes();
  const InstructionSet set = model_.evaluator.instruction_set();
  double sum = layers::spring_energy(model_.layout, set, model_.time, nodes) +
               layers::element_energy(model_.layout, set, model_.time, nodes);
  for (std::uint32_t k = 0; k < model_.node_count(); ++k)
    sum -= model_.mass[k] * model_.loads.gravity().dot(vector_at(model_.state.view.position, k));
  if (std::isfinite(sum) || energy_noted_) return sum;
  energy_noted_ = true;
  const std::string reason =
      layers::explain_failure(model_.layout, set, model_.time, nodes, layers::Requested::forces_and_energies);
  model_.journal.note(
      fmt::format("At {:g} s the energy is not a finite number{}{}. If a law was driven beyond its limit, what follows "
                  "is not a solution; use a smaller time_step.",
                  model_.time, reason.empty() ? "" : ": ", reason));
  return sum;
}

}  // namespace springnet
