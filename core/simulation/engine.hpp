// Owns the model and the parts that work on it, and calls them in order. The stages of a step are in step.cpp.
// Integrators act on the engine through the host table (host_table.cpp); Simulation is its public face.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "simulation/contact_events.hpp"
#include "simulation/dissipation_ledger.hpp"
#include "simulation/impulse_ledger.hpp"
#include "simulation/integrator_calls.hpp"
#include "simulation/linear_model.hpp"
#include "simulation/model.hpp"
#include "simulation/network_info.hpp"
#include "simulation/scheduled_changes.hpp"
#include "simulation/sweep.hpp"
#include "simulation/topology.hpp"

namespace springnet {

class LocalForceModel;
class ParameterModel;
struct VerletStep;

class Engine {
 public:
  // before: of the network before it was extended, where the engine goes on; null: none.
  Engine(const Network& network, const PluginHost& plugins, const SimulationOptions& options,
         const Engine* before = nullptr);
  // For a copy of a simulation of this network, which takes up the state by archive().
  Engine(const Engine& other, const Network& network, const SimulationOptions& options);
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  // ---- a step, for integrators: statuses and messages as in springnet_host ----
  springnet_status begin_step(double from, double until);
  // locates_bodies: events of bodies in contact are located, too.
  springnet_status begin_interval(double from, double until, bool locates_bodies);
  springnet_status run_sweep(const springnet_sweep& sweep);
  springnet_status constrain(const springnet_sweep& sweep);
  springnet_status fire_events(double time, State& state, const std::int32_t* fired);
  springnet_status time_of_impact(springnet_impact_search& search);
  springnet_status project_state(double time, const springnet_vectors& position, const springnet_vectors& velocity);
  springnet_status commit(double time, State& state);
  [[nodiscard]] double next_discontinuity(double time) const noexcept;
  // Drops what is kept for the next step but is not part of the state: derivatives, linear systems, impulses at which
  // iterations would start. (What was withheld from the impulses of obstacles is part of it: momentum balances.)
  void forget() noexcept;

  // ---- the parts ----
  [[nodiscard]] Model& model() noexcept { return model_; }
  [[nodiscard]] const Model& model() const noexcept { return model_; }
  [[nodiscard]] const springnet_network& network_info() { return info_.now(); }
  [[nodiscard]] const springnet_network& network_with_neighbours() { return info_.with_neighbours(); }
  [[nodiscard]] Sweep& sweep() noexcept { return sweep_; }
  [[nodiscard]] LinearModel& linear() noexcept { return linear_; }
  [[nodiscard]] ContactEvents& contact_events() noexcept { return contact_events_; }
  [[nodiscard]] Topology& topology() noexcept { return topology_; }
  [[nodiscard]] ParameterModel& parameters();
  [[nodiscard]] ScheduledChanges& changes() noexcept { return changes_; }
  [[nodiscard]] IntegratorCalls& calls() noexcept { return calls_; }

  // What the steps to come depend on, at a committed state; after forget().
  void archive(Archive& archive);

  // To be called after parameters of laws and neurons, rest lengths, inputs or masses were changed.
  void laws_changed();

  // ---- for Simulation ----
  // At the committed state, computed on demand. Throws Error(simulation) if a law fails.
  [[nodiscard]] const Reactions& reactions();
  // [pair that touches] N, on the first: see smallest_pair_forces().
  [[nodiscard]] const std::vector<Vector3>& pair_forces();
  // The part of a node's reaction that one obstacle exerts, N.
  [[nodiscard]] Vector3 reaction_of(std::uint32_t node, std::size_t surface);
  // J, of springs, elements and gravity. If it is not finite, a note names the time and the law.
  [[nodiscard]] double potential_energy();
  // J since the start; nan unless the options ask for it.
  [[nodiscard]] double dissipated_energy() const noexcept;
  [[nodiscard]] LocalForceModel& local_force();

 private:
  void take_over(const Engine& before, const Network& network);
  // sweeps_follow: as for commit_jumps().
  springnet_status begin(double from, double until, Loads::Change loads, bool sweeps_follow);
  // Settles contacts and ruptures after changes from outside.
  springnet_status settle();
  // End of a step, with sweeps or another method: makes the committed state satisfy its constraints.
  springnet_status commit_sweeps(const State& before);
  springnet_status commit_solution(const State& before, bool jumps);
  // For jumps of prescribed velocities at the committed time. from: s, the time committed before. sweeps_follow: the
  // sweeps of the coming step decide whether nodes separate from surfaces whose motion the program told; nodes then go
  // on as they moved.
  springnet_status commit_jumps(double from, bool sweeps_follow);

  // At the committed state, where events are located.
  springnet_status note_body_forces();

  Model model_;
  LinearModel linear_;
  Topology topology_;
  ContactEvents contact_events_;
  NetworkInfo info_;
  IntegratorCalls calls_;
  Sweep sweep_;
  ImpulseLedger ledger_;
  ScheduledChanges changes_;
  std::unique_ptr<DissipationLedger> dissipation_;  // null: not asked for
  std::unique_ptr<VerletStep> verlet_;              // contact in the last step of velocity Verlet; null: none
  bool swept_ = false;                              // the last commit was one of sweeps; false after forget()
  Reactions reactions_;
  std::vector<Vector3> pair_forces_;
  std::unique_ptr<LocalForceModel> local_force_;  // null: not asked for yet
  std::unique_ptr<ParameterModel> parameters_;    // likewise
  bool energy_noted_ = false;
  std::size_t committed_events_ = 0;   // events when the last commit ended
  std::set<std::size_t> left_behind_;  // noted by note_left_behind()
};

}  // namespace springnet
