// What all parts of the engine work on: the network in memory, what acts on it, the committed state and the journal.
// The parts (sweeps, contact events, topology, linear model) hold what is theirs alone and see no other part unless
// their constructor says so.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <springnet/simulation.hpp>

#include "constraints/constraint_set.hpp"
#include "layers/evaluator.hpp"
#include "layers/failure.hpp"
#include "simulation/journal.hpp"
#include "simulation/loads.hpp"
#include "simulation/recent_touches.hpp"
#include "simulation/state.hpp"

namespace springnet {

// Typical magnitudes of the network as it was at the beginning, for tolerances; all above 0.
struct Scales {
  double length = 1.0;    // m: mean rest length; without springs, the distance of two nodes of an element
  double velocity = 1.0;  // m/s: greatest initial speed, or that which the greatest acceleration reaches over `length`
  double force = 1.0;     // N: greatest weight, load or net force of a node, or m v^2 / length
};

struct Model {
  // The state is that of the scene, without contacts: see start.hpp.
  Model(const Network& network, const PluginHost& plugins, const SimulationOptions& options);
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
  State state;         // committed
  double time = 0.0;   // s, of `state`
  double time_step;    // s, the user's
  Interval interval;   // present step
  double step_length;  // s, of a method that takes the user's steps; 0: it chooses its own
  Journal journal;
  RecentTouches recent_touches;

  // Rises with everything after which a multistep method has to start afresh; that of the loads, with each step whose
  // loads differ from those before.
  std::uint64_t revision = 1, load_revision = 1;
  // What has to be computed anew before it is read.
  struct Stale {
    bool forces = true;     // of `state`
    bool contacts = false;  // whether they and ruptures fit the forces, which changed from outside of a step
    bool reactions = true;
  } stale;
  // The integrator's own functions are running, which must not change the model.
  bool in_callback = false;

  [[nodiscard]] std::uint32_t node_count() const noexcept { return layout.node_count(); }
  [[nodiscard]] std::uint32_t user_number(std::uint32_t node) const { return layout.ordering().user[node]; }
  // Obstacles and prescribed nodes at a time of the present interval.
  [[nodiscard]] std::shared_ptr<const Placement> placement(double at) const { return contact.at(interval.at(at)); }
  [[nodiscard]] std::shared_ptr<const Placement> placement_now() const { return contact.at(just_after(time)); }
  // Loads as they are in an evaluation at a time, s; valid until one at another time.
  [[nodiscard]] layers::ExternalForces external_at(double at);
  // The committed state with its forces, which are evaluated if they are stale. Throws Error(simulation) where a law
  // fails.
  const State& with_forces();
  // Springs, elements, loads or the state changed.
  void changed() noexcept;

  // A node this close to an obstacle lies on it, m.
  [[nodiscard]] double contact_tolerance() const noexcept;
  // A node that an obstacle stopped has no speed against it but rounding, m/s.
  [[nodiscard]] double no_speed() const noexcept;
  // Records an event of a node (engine's number) and an obstacle.
  void record(Event::Kind kind, double at, std::uint32_t node, std::int32_t surface,
              const Vector3& impulse = Vector3::Zero()) {
    journal.record(kind, at, user_number(node), surface, impulse);
  }
  // Remembers why numbers are not finite at a state, unless that is known.
  void explain(double at, const layers::NodeArrays& nodes, layers::Requested requested = layers::Requested::forces);
  // The same of an evaluation that a law or a neuron ended; returns `status`.
  springnet_status failed(springnet_status status, double at, const layers::NodeArrays& nodes);
};

}  // namespace springnet
