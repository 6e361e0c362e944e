// The network at work: memory layout, evaluation, loads, contacts, changes of topology, and the state. Integrators act
// on it through the host table (host_table.cpp); Simulation is its public face.
#pragma once

#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <springnet/simulation.hpp>

#include "constraints/constraint_set.hpp"
#include "layers/elements.hpp"
#include "layers/evaluator.hpp"
#include "layers/linearisation.hpp"
#include "simulation/cutting.hpp"
#include "simulation/loads.hpp"
#include "simulation/requests.hpp"
#include "simulation/state.hpp"

namespace springnet {

class LinearSweep;

class Engine {
 public:
  Engine(const Network& network, const PluginHost& plugins, const SimulationOptions& options);
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  // ---- what integrators ask for; statuses and messages as the C ABI wants them ----
  [[nodiscard]] const springnet_network& network_info();
  springnet_status begin_step(double from, double until);
  // The same with loads that follow the time of each evaluation.
  springnet_status begin_interval(double from, double until);
  springnet_status evaluate(const springnet_evaluation& request);
  springnet_status evaluate_nodes(const springnet_evaluation& request, const std::uint32_t* nodes, std::uint32_t count);
  springnet_status sweep(const springnet_sweep& sweep);
  springnet_status constrain(const springnet_sweep& sweep);
  springnet_status linearise(const springnet_evaluation& at);
  springnet_status jacobian_times(const double* dp, const double* dv, double* out);
  springnet_status factorise(double velocity_weight, double position_weight);
  springnet_status project(const double* mobility, double* values);
  springnet_status linear_sweep(const springnet_sweep& sweep);
  springnet_status project_state(double time, const springnet_vectors& position, const springnet_vectors& velocity);
  springnet_status event_values(const springnet_evaluation& at, double* values, std::int32_t* directions);
  springnet_status fire_events(double time, State& state, const std::int32_t* fired);
  // When a node first touches a surface in a part of a step, s; nan if none does. See springnet_host.
  springnet_status time_of_impact(const springnet_impact_search& search, double& time);
  springnet_status commit(double time, State& state);
  [[nodiscard]] double next_discontinuity(double time) const noexcept;
  [[nodiscard]] layers::Linearisation& linearisation() noexcept { return linearisation_; }
  [[nodiscard]] springnet_message& message() noexcept { return message_; }
  // A number or a note of the integrator; any thread of a sweep may have one. Of more than a few hundred numbers, or
  // notes, those that come later are left out.
  void report(const std::string& name, double value);
  void note(const std::string& text);
  // States for the integrator to work with. The engine owns them, and knows no others.
  [[nodiscard]] springnet_state* create_state();
  void destroy_state(const springnet_state* state) noexcept;
  // Throws Error(plugin) if `state` is none of them.
  [[nodiscard]] State& created_state(const springnet_state* state);
  // Throws Error(plugin) within a sweep: a node's update may not call what changes the engine.
  void require_no_sweep() const;
  // Throws Error(plugin) while the integrator tells its limits.
  void require_advancing() const;
  // A failed call of the integrator: its reason becomes the message, and `misuse` if the fault was the integrator's.
  void refuse_call(const std::string& reason, bool misuse) noexcept;

  // ---- what Simulation asks for ----
  // The integrator is about to tell its limits, or has: it may not commit or fire events meanwhile.
  void ask_limits(bool asks) noexcept { asks_limits_ = asks; }
  // The integrator is about to advance the network to `until`, s: it may commit no later time. Forgets earlier misuse.
  void begin_advance(double until);
  // What the integrator last did against the rules of plugin.h since then; empty: nothing.
  [[nodiscard]] const std::string& misuse() const noexcept { return misuse_; }
  // Rounding of the end of the present advance, s.
  [[nodiscard]] double end_tolerance() const noexcept;
  [[nodiscard]] const layers::Layout& layout() const noexcept { return layout_; }
  [[nodiscard]] const layers::Evaluator& evaluator() const noexcept { return evaluator_; }
  [[nodiscard]] const ConstraintSet& constraints() const noexcept { return constraints_; }
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
  [[nodiscard]] const std::vector<double>& mass() const noexcept { return mass_; }
  [[nodiscard]] double time() const noexcept { return time_; }
  // Loads as they are in an evaluation at `time`, s; valid until one at another time.
  [[nodiscard]] layers::ExternalForces external_at(double time) {
    loads_.follow(interval_.at(time).rate);
    return loads_.external();
  }
  // The committed state; its forces are evaluated anew if something changed since they were.
  [[nodiscard]] const State& state();
  [[nodiscard]] const State& state_without_forces() const noexcept { return state_; }
  [[nodiscard]] Loads& loads() noexcept { return loads_; }
  [[nodiscard]] const std::vector<Event>& events() const noexcept { return events_; }
  [[nodiscard]] const std::map<std::string, double>& statistics() const noexcept { return statistics_; }
  // What holds, moves or stops nodes at the committed state.
  struct Reactions {
    std::vector<Vector3> node;  // N, of fixation and surfaces; 0 for one that nothing holds
    std::vector<double> rigid;  // N, > 0 is tension
  };
  [[nodiscard]] const Reactions& reactions();
  // What of it is one surface's, of a node that touches it, N.
  [[nodiscard]] Vector3 reaction_of(std::uint32_t node, std::size_t surface);
  void move_surface(std::size_t surface, const Vector3& position, double time);
  void move_node(std::uint32_t node, const Vector3& position, double time);
  // Why numbers were not finite or could not be evaluated since begin_step(); empty if all went well.
  [[nodiscard]] const std::string& non_finite() const noexcept { return non_finite_; }
  // J, of springs, elements and gravity at the committed state. Where it is not finite, a note says since when, and
  // which law it is.
  [[nodiscard]] double potential_energy();
  // Something was changed from outside: a multistep method has to start afresh, forces are stale.
  void changed() noexcept;
  void set_node(std::uint32_t node, const std::optional<Vector3>& position, const std::optional<Vector3>& velocity);
  void set_fixed(std::uint32_t node, bool fixed);
  std::size_t cut(const std::vector<std::uint32_t>& springs);
  std::size_t cut(const CuttingPolygon& polygon);

 private:
  struct ScheduledCut {
    double time;
    std::vector<std::uint32_t> springs;
    std::optional<CuttingPolygon> polygon;
    bool done = false;
  };
  struct EventSource {
    // rest: the slip that is about to end has no speed left along its direction; slow, quick: its direction is kept
    // from now on, or followed; stall: the acceleration of a slip that began turns round.
    // seam: a sliding node passes a line where the curvature of its surface jumps.
    enum class Kind : std::uint8_t { touch, release, slip, rest, slow, quick, stall, seam, rupture, element_rupture };
    Kind kind;
    std::uint32_t index;  // node, spring or element
    std::uint32_t surface;
    // Added to its value: of a touch, m, how far behind the surface it counts; of a slip, N; of a release, m/s^2.
    double depth = 0.0;
  };
  class ImpactSearch;
  class ReactionsAt;
  class Settling;
  struct AnchoredCluster;
  class Stepping;
  struct NodeEvaluation;

  // What begins at `from`, once the loads are known.
  springnet_status begin(double from, double until, Loads::Change loads);
  // `size`: of the scene, m.
  void start_constraints(double size);
  // Where surfaces and moved nodes are at a time of the present interval.
  [[nodiscard]] const std::shared_ptr<const Placement>& placement(double time) const {
    return contact_.at(interval_.at(time));
  }
  // Puts prescribed nodes where they are, right after the committed time. Where the velocity of one jumps, what hangs
  // rigidly on it is taken along, as if no surface acted, and who moves it is told the impulses. Returns these
  // clusters.
  std::set<std::uint32_t> follow_prescribed();
  // Decides anew which nodes are held, slide or are free, as velocities and forces have it.
  springnet_status settle_contacts(double time, State& state);
  [[nodiscard]] double contact_tolerance() const noexcept;
  void set_scales();
  void perform_due_cuts();
  springnet_status perform_due_ruptures();
  // Springs, and what goes with them; elements and loaded faces besides. Returns the number of springs.
  std::size_t remove(const std::vector<std::uint32_t>& springs, const std::vector<std::uint32_t>& elements,
                     const std::vector<std::size_t>& faces, Event::Kind kind, double time);
  // Returns whether any went.
  bool remove_faces(const std::vector<std::size_t>& faces, double time);
  void let_go(std::uint32_t node);
  // Nodes that went behind a surface unseen.
  springnet_status stop_penetration(double time, State& state);
  // At the committed time, `from` the one before, s: surfaces whose velocity jumps away from nodes leave them where
  // they are, strike them, or take them along.
  springnet_status follow_jumps(double from);
  [[nodiscard]] double coefficient(std::uint32_t node, std::size_t surface) const;
  springnet_status acceleration_let_go(const EventSource& release, const ReactionsAt& at, double& value) const;
  [[nodiscard]] double beyond_cone(const EventSource& slip);      // N
  [[nodiscard]] double beyond_brace(const EventSource& release);  // m/s^2
  // The value of an event of a contact.
  springnet_status contact_event(const EventSource& source, ReactionsAt& reactions, double& value);
  // Whether a node is about to touch within the tolerance.
  [[nodiscard]] bool touches_now(const EventSource& source, const Placement& at, const State& state,
                                 double depth) const;
  struct Finding;
  springnet_status settle(double time, State& state, const std::map<std::uint32_t, Finding>& findings);
  [[nodiscard]] double no_speed() const noexcept;  // m/s
  void note_grazing(std::uint32_t node, std::size_t surface, double time);
  // Surfaces that left nodes behind since the last commit, at `from`, s, because their velocity jumped.
  void note_shed(double from);
  // No forces and impulses of surfaces were found that fit a node and what hangs rigidly on it.
  void note_unresolved(std::uint32_t node, double time);
  // The error that these surfaces leave no place to a node.
  springnet_status no_place(std::uint32_t node, const std::vector<std::int32_t>& surfaces, double time);
  // Nodes that are behind surfaces that they touch, where no positions fit them all.
  springnet_status find_squeezed(double time, const State& state);
  // The slip of a node begins or ends where errors of integration decide whether.
  void note_grazing_slip(std::uint32_t node, std::size_t surface, double time);
  // Of a sweep in an order; `tile_context` is that of the sweep.
  springnet_status sweep_in_order(const springnet_sweep& sweep, void* tile_context);
  springnet_status sweep_set(std::uint32_t set, void* tile_context);
  enum class Turn : std::uint8_t { all, others, joined_to_all };  // of which nodes of a range
  [[nodiscard]] bool is_joined_to_all(std::uint32_t node) const;
  springnet_status update_range(std::uint32_t begin, std::uint32_t end, std::uint32_t unit, Turn turn,
                                void* tile_context, springnet_message& message);
  springnet_status update_cluster(std::size_t cluster, std::uint32_t unit, void* tile_context,
                                  springnet_message& message);
  springnet_status evaluate_for_update(std::uint32_t node, void* tile_context, NodeEvaluation& result,
                                       springnet_message& message);
  springnet_status update_node(std::uint32_t node, std::uint32_t unit, void* tile_context,
                               const NodeEvaluation& evaluation, springnet_message& message);
  springnet_status linearise_constraints(const springnet_evaluation& at);
  void note_sweep(const springnet_sweep& sweep) noexcept;
  // The contacts of sweeps become the committed ones, and what surfaces gave at once is counted.
  springnet_status commit_sweeps(double time);
  // What surfaces gave a node, and what fixation gave it, at once, N s.
  // Returns what of it is each surface's.
  std::vector<Vector3> book_contact(std::uint32_t node, const std::vector<std::int32_t>& surfaces, const Placement& at,
                                    const Vector3& impulse);
  void book_motion(std::uint32_t node, const Placement& end);
  springnet_status book_anchored(const AnchoredCluster& anchored, ReactionsAt& reactions);
  // How nodes that hang rigidly on fixed ones begin the step, for that.
  springnet_status note_anchored();
  // What a constrain asks for that is a drift or a kick.
  springnet_status step_explicitly(const springnet_sweep& step);
  void note(Event::Kind kind, double time, std::uint32_t user_index) { events_.push_back({kind, time, user_index}); }
  [[nodiscard]] const std::vector<EventSource>& event_sources();
  struct Rupturing {
    std::vector<std::uint32_t> springs, elements;
    [[nodiscard]] std::size_t count() const noexcept { return springs.size() + elements.size(); }
  };
  [[nodiscard]] const Rupturing& rupturing();
  // [count()] margins of the springs, then of the elements.
  springnet_status rupture_margins(double time, const layers::NodeArrays& nodes, double* margins);
  void explain(double time, const layers::NodeArrays& nodes, layers::Asked asked = layers::Asked::forces);
  bool check_finite(bool forces, std::uint32_t bad_neuron, double time, const layers::NodeArrays& nodes);
  springnet_status failed(springnet_status status, double time, const layers::NodeArrays& nodes);
  void note_energy();
  // Throws Error if the integrator may not commit this.
  void check_commit(double time, const State& state);
  // SPRINGNET_RECOVERABLE and a message where surfaces have closed on a node that they touch.
  springnet_status check_room(double time, const State& state);

  layers::Layout layout_;
  std::vector<double> mass_;
  layers::Evaluator evaluator_;
  Loads loads_;
  ConstraintSet constraints_;
  Contact& contact_;               // its contacts, which events change,
  const RigidConnections& rigid_;  // and its rigid connections
  layers::Linearisation linearisation_;
  std::shared_ptr<LinearSweep> linear_sweep_;  // of it; null: not made since linearise()
  std::vector<std::uint32_t> no_cluster_;      // [node] of network_info without rigid connections
  State state_;
  std::vector<std::unique_ptr<State>> created_states_;
  double time_ = 0.0;
  double time_step_;                                 // s
  double step_length_ = 0.0;                         // s, of a method with steps of its user's; 0: of its own
  double advance_from_ = 0.0, advance_until_ = 0.0;  // s
  std::string misuse_;
  bool asks_limits_ = false;
  bool forces_stale_ = true;
  bool unsettled_ = false;              // something changed after which contacts and ruptures are looked at anew
  bool swept_ = false;                  // since the last commit
  bool swept_decided_ = false;          // about contacts
  std::shared_ptr<Stepping> stepping_;  // of velocity Verlet, the last step; null: none
  std::vector<Vector3> withheld_;  // [node] N: what reactions_at.hpp's told() left out at the last commit; may be empty
  struct AnchoredCluster {
    std::size_t cluster;
    std::vector<Vector3> velocity, acceleration;  // m/s, m/s^2, [node of the cluster]
  };
  std::vector<AnchoredCluster> anchored_;  // clusters with fixed nodes, as the step began
  double swept_rest_ = 0.0;                // s: 1 - theta times the time constant
  double swept_weight_ = 0.0;              // s: theta times the time constant of the last sweep
  std::vector<ScheduledCut> cuts_;
  std::vector<Event> events_;
  std::map<std::string, double> statistics_;
  std::string non_finite_;
  springnet_message message_{};
  springnet_network info_{};
  std::uint64_t revision_ = 1;
  std::uint64_t info_revision_ = 0;
  std::uint64_t load_revision_ = 1;
  std::uint64_t sources_revision_ = 0;
  std::vector<EventSource> sources_;
  double grazing_touches_ = 0.0;
  std::size_t committed_events_ = 0;  // events when the last commit ended
  std::set<std::size_t> shedding_;    // surfaces of which note_shed() told
  struct Touches {
    int count = 0;
    double last = -std::numeric_limits<double>::infinity();  // s
  };
  std::map<std::uint32_t, Touches> touches_;  // in quick succession, of nodes that touched
  std::mutex failure_lock_;                   // of messages and reports, where nodes are updated by several threads
  bool in_sets_ = false;                      // several threads write outputs
  bool in_sweep_ = false;                     // updates of the integrator are called,
  bool in_tiles_ = false;                     // tile by tile, from several threads
  OrderCheck order_check_;
  layers::SurfaceVolumes swept_volumes_;    // of closed surfaces within a sweep in an order,
  layers::SurfaceVolumes asked_volumes_;    // and of a call of evaluate_nodes outside
  std::vector<std::uint8_t> cluster_done_;  // within a sweep in an order
  Interval interval_;                       // of begin_step, or begin_interval
  std::vector<std::string> notes_;
  std::optional<double> potential_energy_;  // J; empty: not known
  bool energy_noted_ = false;
  std::set<std::uint32_t> torn_loads_;  // of which faces went
  std::size_t torn_faces_ = 0;
  Reactions reactions_;
  bool reactions_known_ = false;
  bool rupturing_known_ = false;
  Rupturing rupturing_;
  std::vector<double> scratch_;  // forces and accelerations that are not answered
};

}  // namespace springnet
