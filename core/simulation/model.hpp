// The data that all parts of the engine work on: the network in memory, loads and constraints, the committed state and
// the journal. The parts (sweeps, contact events, topology, linear model) hold private data only, and know another part
// only if their constructor takes it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <springnet/simulation.hpp>

#include "constraints/constraint_set.hpp"
#include "layers/evaluator.hpp"
#include "layers/failure.hpp"
#include "layers/linear/deadline.hpp"
#include "simulation/journal.hpp"
#include "simulation/loads.hpp"
#include "simulation/recent_touches.hpp"
#include "simulation/state.hpp"

namespace springnet {

// Typical magnitudes of the network at its start, for tolerances; all above 0.
struct Scales {
  double length = 1.0;  // m: mean rest length; without springs, the distance of two nodes of an element
  // m/s: greatest initial speed of a node, speed of a prescribed motion, or that which the greatest acceleration
  // reaches over `length`
  double velocity = 1.0;
  double force = 1.0;  // N: greatest weight, load or net force of a node, or m v^2 / length
  // Smaller forces, in units of `force`, are rounding, for example those of a node just released, and decide nothing.
  static constexpr double min_force = 1e-9;
};

struct Model {
  // The state is that of the scene, without contacts: see start.hpp.
  Model(const Network& network, const PluginHost& plugins, const SimulationOptions& options)
      : Model(network, plugins, options, nullptr) {}
  // before: of the network before it was extended, whose state and time the old nodes keep; null: none.
  Model(const Network& network, const PluginHost& plugins, const SimulationOptions& options, const Model* before);
  // For a copy of a simulation of this network, which takes up the state by archive(). Shares what does not change.
  Model(const Model& other, const Network& network, const SimulationOptions& options);
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  layers::Layout layout;
  std::vector<double> mass;  // [node] kg
  layers::Evaluator evaluator;
  Loads loads;
  ConstraintSet constraints;
  Contact& contact;               // of the constraints: contacts, which events change,
  const RigidConnections& rigid;  // and rigid connections
  Scales scales;
  State state;                        // committed
  double time = 0.0;                  // s, of `state`
  double time_step;                   // s, the user's
  Interval interval;                  // present step
  double step_length;                 // s, of a method that takes the user's steps; 0: it chooses its own
  double position_uncertainty = 0.0;  // m, between the ends of a step, of a method that locates events
  Journal journal;
  Deadline deadline;  // of the present step
  RecentTouches recent_touches;
  RecentTouches recent_slips;  // of pairs, by their first nodes: those that began or ended

  // `revision` increases with every change after which a multistep method must restart, `load_revision` with every step
  // whose loads differ from those before.
  std::uint64_t revision = 1, load_revision = 1;
  // What must be computed anew before it is read.
  struct Stale {
    bool forces = true;     // of `state`
    bool contacts = false;  // and ruptures: forces changed from outside of a step
    bool reactions = true;
    bool pair_forces = true;  // of bodies that touch
  } stale;
  // At `time` a motion that the embedding program told a surface or node begins or ends: its velocity jumps when the
  // next step begins, to that of the motion told last. `time_before`: s, before the last commit.
  bool jumps_due = false;
  double time_before = 0.0;
  // A callback of the integrator is running, which must not change the model.
  bool in_callback = false;

  // The internal state of laws in an evaluation that asks for this; null: that committed. Throws Error(plugin) if it
  // asks for what cannot be.
  [[nodiscard]] layers::InternalView internal_for(const springnet_internal* request);
  // What is where in the model before.
  [[nodiscard]] layers::NumbersBefore numbers_in(const Model& before) const;
  // To be called where a step begins, whose start steps of internal states read.
  void begin_internal_steps() noexcept { start_known_ = false; }
  // Sets the internal states with which laws begin. Throws Error(simulation) if one fails.
  void start_internal();

  [[nodiscard]] std::uint32_t node_count() const noexcept { return layout.node_count(); }
  [[nodiscard]] std::uint32_t user_number(std::uint32_t node) const { return layout.ordering().user[node]; }
  // Obstacles and prescribed nodes at a time of the present interval.
  [[nodiscard]] std::shared_ptr<const Placement> placement(double at) const {
    return contact.at(jumps_due && at == time ? now() : interval.at(at));
  }
  [[nodiscard]] std::shared_ptr<const Placement> placement_now() const { return contact.at(now()); }
  // The present time: after jumps of prescribed velocities, but before those that are still due.
  [[nodiscard]] SampleTime now() const noexcept { return jumps_due ? just_before(time, time_step) : just_after(time); }
  // Loads for an evaluation at a time, s; valid until the next call with another time.
  [[nodiscard]] layers::ExternalForces external_at(double at);
  // The committed state with its forces, evaluated if they are stale. Throws Error(simulation) if a law fails.
  const State& with_forces();
  // To be called after changes of springs, elements, loads or the state.
  void changed() noexcept;

  // Nodes closer than this to an obstacle lie on it, m.
  [[nodiscard]] double contact_tolerance() const noexcept;
  // Smaller speeds relative to an obstacle are rounding, m/s.
  [[nodiscard]] double no_speed() const noexcept;
  void set_mass(std::uint32_t node, double value);  // kg
  // [node] As the network was given, kg.
  [[nodiscard]] const std::vector<double>& first_mass() const noexcept {
    return first_mass_.empty() ? mass : first_mass_;
  }
  // The committed state, and all that has changed since the start.
  void archive(Archive& archive);
  // Where a node is in an event, and how it moves before the event changes that; m, m/s.
  struct NodeAt {
    Vector3 position, velocity;
  };
  // Records an event of a node (engine's number) and an obstacle (-1: unknown), which is at `placed`. impulse: N s.
  void record(Event::Kind kind, double at, std::uint32_t node, std::int32_t surface, const NodeAt& node_at,
              const Placement& placed, const Vector3& impulse = Vector3::Zero());
  // Remembers why numbers are not finite at a state, unless that is known.
  void explain(double at, const layers::NodeArrays& nodes, layers::Requested requested = layers::Requested::forces);
  // The same of an evaluation that a law or a neuron ended; returns `status`.
  springnet_status failed(springnet_status status, double at, const layers::NodeArrays& nodes);

 private:
  void take_over(const Model& before, const Network& network);
  void take_over_internal(const Model& before);
  void archive_masses(Archive& archive);

  std::vector<double> first_mass_;  // empty: none has been changed
  // Invariants and rates at the committed state, see layers::InternalView; empty where nobody reads them.
  std::vector<double> start_q_, start_rate_;
  bool start_known_ = false;
};

}  // namespace springnet
