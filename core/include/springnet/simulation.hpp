// Simulation of a network.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <springnet/error.hpp>
#include <springnet/export.hpp>
#include <springnet/instruction_set.hpp>
#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet {

class Profiler;

struct SimulationOptions {
  double time_step = 0.01;  // s: the paper's time constant t_c
  LawUse integrator{"recurrent", {}};
  unsigned threads = 0;  // 0: chosen by machine and size of the network. 1: starts no thread.
  InstructionSet instruction_set = InstructionSet::best;
  bool renumber = true;  // false: node k of the user is column k of positions()
  // Sums up what laws dissipate (Simulation::dissipated_energy()): an evaluation of all laws for each step, on one
  // thread. It changes no other result.
  bool dissipated_energy = false;
  // Takes the time of the steps (profile.hpp), and of nothing else of the simulation; null: nothing.
  std::shared_ptr<Profiler> profiler{};
};

// out_of_time: at a deadline (Simulation::step_within) the best state until then was taken.
enum class Outcome { settled, oscillating, out_of_sweeps, diverging, out_of_time };
// "settled", "oscillating", "out of sweeps", …
[[nodiscard]] SPRINGNET_API std::string_view name_of(Outcome outcome) noexcept;

// Report on the steps of the last call of step() or advance_to().
struct StepReport {
  Outcome outcome = Outcome::settled;  // settled if all did, else that of the last step that did not
  std::uint64_t steps = 0;             // committed
  std::uint64_t sweeps = 0;            // or evaluations of all springs
  double force_difference = 0.0;       // N; nan if not compared: exactly one sweep was requested
  double residual = 0.0;               // N; nan if not evaluated
  NodeIndex node = 0;                  // with the greatest force difference
  std::int64_t start_node = -1;        // where the last sweep started; -1: the rule has no start node
  std::uint64_t substeps = 0;          // smaller steps made in place of time steps that did not settle
  std::uint64_t stages = 0;            // smaller time constants passed on the way to the full one
  // m, of a step with a deadline: estimate of the greatest distance of a node from where it is in the settled step.
  // nan: not estimated; that of steps without a deadline.
  double position_error = std::numeric_limits<double>::quiet_NaN();
};

// An event of a spring, an element or a node.
struct Event {
  // jammed: no finite force can keep a node in contact from penetrating (Painlevé); an impulse stops it.
  // met, parted: of bodies, see `pair`; where events are located also slipped and stuck.
  enum class Kind { cut, ruptured, touched, released, slipped, stuck, jammed, met, parted };
  Kind kind;
  double time;  // s
  // Spring or element (cut, ruptured) or node (touched, released, jammed; slipped, stuck: Coulomb friction).
  std::uint32_t index;
  bool element = false;  // cut or ruptured (by its own law or with a spring between its nodes): `index` is an element
  // For a node: the surface (planes, then instruments; -1: unknown), and its impulse on the node, N s.
  std::int32_t surface = -1;
  Vector3 impulse = Vector3::Zero();
  // At that moment, before it changes anything (velocities in sweeps at the start of the step, of verlet in its
  // middle): where the node, or the middle of the spring's or element's nodes is, m; its velocity, m/s; the direction
  // from the surface to the node, of length 1 (zero for springs and elements).
  Vector3 position = Vector3::Zero();
  Vector3 velocity = Vector3::Zero();
  Vector3 normal = Vector3::Zero();
  // Of a spring its length, m, and tension, N; of an element its invariant and generalised force. nan for a node.
  double value = std::numeric_limits<double>::quiet_NaN();
  double force = std::numeric_limits<double>::quiet_NaN();
  // Of bodies that met, parted, slipped or stuck: what of them. The first has pair_first nodes (1: a node, 2: an edge),
  // the second those up to pair_count (one: a node, two: an edge, three: a face). `index` is the first one's first;
  // impulse, position and velocity are those of the first, normal is the direction from the second.
  std::array<std::uint32_t, 4> pair{};
  std::uint8_t pair_first = 0, pair_count = 0;
};

// Two bodies in contact at the end of the last step: a node and a node or a face, or two edges.
struct BodyTouch {
  std::array<NodeIndex, 4> nodes{};  // user's numbers; those of the first, then those of the second
  std::uint8_t first = 0, count = 0;
  std::array<double, 4> weights{};     // of the nodes, where they touch: of the first 1 in all, of the second -1
  Vector3 position = Vector3::Zero();  // m, between both
  Vector3 normal = Vector3::Zero();    // unit, from the second to the first
  Vector3 force = Vector3::Zero();     // N, on the first: mean over the last step; at the time where events are located
};

// What a grasped node or a surface feels near where it is: the force at the end of a step, and how it would differ had
// the step taken the node or the surface elsewhere. For programs that render forces more often than they make steps.
struct LocalForce {
  double time = 0.0;                                    // s, of the state
  Vector3 position = Vector3::Zero();                   // m, of the node; of the surface, surface_position()
  Vector3 force = Vector3::Zero();                      // N, of the network on what holds the node, or the surface
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();  // N/m, minus the derivative of the force
  [[nodiscard]] Vector3 at(const Vector3& x) const { return force - stiffness * (x - position); }  // N
};

// Vector quantities of all nodes without a copy: 3 x nodes, one row a coordinate, in the engine's order of nodes.
using ConstNodeMap =
    Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>, 0, Eigen::OuterStride<>>;

// One number for each spring, likewise without a copy, [user's number].
using ConstValueMap = Eigen::Map<const Eigen::VectorXd>;

// Energies by kind, J. nan: a law that has no energy is among them.
struct Energies {
  double kinetic = 0.0;
  double springs = 0.0;
  double elements = 0.0;
  double gravity = 0.0;  // relative to the origin
  [[nodiscard]] double total() const { return kinetic + springs + elements + gravity; }
};

// A place on a spring.
struct NearestSpring {
  SpringIndex spring = 0;
  double distance = 0.0;            // m
  double along = 0.0;               // 0: at its first node, 1: at its second
  Vector3 point = Vector3::Zero();  // m
};

// Where a ray first meets a face of a body or a surface. Both count from both sides; from within an instrument: where
// the ray leaves it. A face is torn with a spring along one of its sides, with the loads on it, or with the elements
// that have its corners.
struct RayHit {
  double distance = 0.0;            // m, from the origin of the ray
  Vector3 point = Vector3::Zero();  // m
  std::int64_t face = -1;           // in Network::faces(); -1: a surface was met
  std::int32_t surface = -1;        // planes, then instruments; -1: a face was met
  NodeIndex node = 0;               // the face's corner next to the point
};

// The state after a step, for a thread that draws it while the next one is made. Costs a copy a step.
struct Snapshot {
  double time = 0.0;  // s
  std::uint64_t steps = 0;
  Eigen::Matrix3Xd positions, velocities;  // m, m/s; [user's node]
  std::size_t live_springs = 0, events = 0;
};

// The largest time step of an integrator at the present state.
struct TimeStepLimit {
  std::string rule;                                             // empty: the integrator has no rules to choose from
  double time_step = std::numeric_limits<double>::quiet_NaN();  // s; infinity: none; nan: not known
  std::optional<NodeIndex> node{};                              // that sets it
  std::string reason{};                                         // why it is not known, or what sets it
};

// An internal state of a law, as the law declares it.
struct InternalState {
  std::string name;           // "flow"
  std::string unit;           // SI, for a law of a length; "1": dimensionless
  bool of_viscosity = false;  // of the viscosity function, else of the spring function
  bool operator==(const InternalState&) const = default;
};

class SPRINGNET_API Simulation {
 public:
  // Throws Error(input) or Error(plugin). `plugins` may be shared between simulations.
  Simulation(const Network& network, std::shared_ptr<const PluginHost> plugins, const SimulationOptions& options = {});
  // The same without a copy of the network, which must not change any more.
  Simulation(std::shared_ptr<const Network> network, std::shared_ptr<const PluginHost> plugins,
             const SimulationOptions& options = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  // Makes one time step. Throws Error(simulation) if it does not settle and the integrator's policy is `error`, or if a
  // number is not finite. The state is then the last one reached, that of time(): the state before the step or, with an
  // integrator that stops at events, that of the last event within it.
  const StepReport& step();
  // The same within `seconds` of wall time, for a program that must draw: `recurrent` then stops between sweeps, or in
  // the solution of a linear system, once another sweep like the last one would take longer than what is left, and
  // takes the best state until then, with Outcome::out_of_time. How far it is from the settled step is told by
  // `residual` and `position_error` of the report. One sweep is always made, however small `seconds` is (0: one sweep).
  // Surfaces keep nodes out, and rigid connections keep their lengths, as always. Results then depend on the machine
  // and its load. With time enough, and with integrators that know no deadline (cvode, verlet, those of other authors),
  // it is step(). Throws as step(), and Error(input) if `seconds` is below 0 or not a number.
  const StepReport& step_within(double seconds);
  // Makes time steps until `time`; the last one is shortened to end there.
  const StepReport& advance_to(double time);
  // The same; go_on() is asked after each step, the last one included, and ends it there with false.
  const StepReport& advance_to(double time, const std::function<bool()>& go_on);

  // Called by the thread that steps or changes the simulation, once the state is consistent, for each event in order;
  // and after each step. They may read the simulation (all const functions, between(), local_force()), not change it.
  // Events of a step that fails are told before its error is thrown. Exceptions end the call that they come from, whose
  // step is made. Empty: none.
  void on_event(std::function<void(const Event&)> callback);
  void on_step(std::function<void(const StepReport&)> callback);

  // Drops all that the integrator and the engine keep from step to step only to be faster, or to choose the next step
  // by those before: derivatives and preconditioners, earlier velocities, estimates, the history of a multistep method.
  // What follows then depends on the state alone (with the time, loads, contacts and springs that are left), bit by
  // bit. Call it where a state is saved, so that a run that goes on there gives the same bits as one restored from it.
  // State, report, statistics, notes and the grid of time steps do not change. Not while another thread uses this
  // object. Throws Error(plugin) if the integrator breaks a rule; Error(input) if it has no way to forget and cannot be
  // created anew.
  void drop_history();
  // From any thread, also within a signal handler: the step that is being made, or the next one, ends as soon as its
  // integrator can, with Outcome::out_of_time and the best state it has (step_within). One that cannot ends as usual.
  void ask_to_stop() noexcept;
  // What the integrator keeps from one step to the next, as bytes for set_integrator_memory() of a simulation of the
  // same network, options and state: it then goes on with the same bits. Empty where the integrator cannot tell it;
  // such a simulation goes on as after drop_history(). The bytes are for the same machine and version.
  [[nodiscard]] std::string integrator_memory();
  // Throws Error(input) if these are not of this integrator; it then keeps nothing, as after drop_history().
  void set_integrator_memory(std::string_view memory);
  // All that the coming steps depend on, as bytes for restore(): time, state, states of laws, inputs, contacts,
  // friction, motions, events, notes, loads, removed springs, changes of laws and masses, the integrator and its
  // memory. The integrator drops what it keeps for speed alone (drop_history()), so that this simulation and one that
  // is restored go on with the same bits. The bytes are for the same version and machine. Throws as drop_history().
  [[nodiscard]] std::string save();
  // Takes up the state of a simulation of the same network with the same options, also an earlier one of this object:
  // springs that were removed since are there again, changes are taken back. Throws Error(input) that says what is
  // wrong with bytes that are damaged, or of another network, law, integrator or version (which part of it is another
  // one: "rest lengths of springs: …"), Error(plugin) if the state's integrator is not installed; this simulation then
  // stays as it was, but for its history. Bytes from a stranger can do no more than give a wrong motion.
  void restore(std::string_view saved);
  // The same in a file. It is written beside the file and takes its place once it is whole and on the disk, so that
  // there is always the one before or the new one. A link stays; what it leads to is replaced. Throw Error(input) that
  // names the file.
  void save_to(const std::filesystem::path& file);
  void restore_from(const std::filesystem::path& file);
  // A copy that goes on by itself, also in another thread, with the same bits. What does not change is shared. Drops
  // the history as save() does. Callbacks, snapshots and the profiler are not those of the copy. Throws as
  // drop_history().
  [[nodiscard]] Simulation clone();
  // Positions and velocities, columns as in positions(), at a time (s) within the integrator's last step. Empty where
  // it has none: it has no dense output, the time is another one, or an event ended the step. At time() it is the
  // present state, with changes since the step and velocities after a jump of a prescribed motion; after a change of
  // positions, velocities or fixed nodes it is known there alone.
  struct Between {
    Eigen::Matrix3Xd positions, velocities;
  };
  [[nodiscard]] std::optional<Between> between(double time);

  // Snapshots are kept from now on, or no longer. snapshot(), from any thread: that after the last step or change that
  // is done; null: none is kept.
  void keep_snapshots(bool keep = true);
  [[nodiscard]] std::shared_ptr<const Snapshot> snapshot() const;

  [[nodiscard]] double time() const noexcept;
  [[nodiscard]] double time_step() const noexcept;
  [[nodiscard]] std::uint64_t steps() const noexcept;   // since the beginning
  [[nodiscard]] std::uint64_t sweeps() const noexcept;  // since the beginning
  [[nodiscard]] std::size_t node_count() const noexcept;
  [[nodiscard]] std::size_t spring_count() const noexcept;  // as added by the user, including removed ones
  [[nodiscard]] std::size_t live_spring_count() const noexcept;
  [[nodiscard]] std::size_t element_count() const noexcept;  // likewise
  [[nodiscard]] unsigned threads() const noexcept;
  [[nodiscard]] InstructionSet instruction_set() const noexcept;
  [[nodiscard]] const StepReport& last_report() const noexcept;

  // Valid until the simulation is advanced or changed. Column columns()[k] belongs to the user's node k;
  // positions()(Eigen::all, columns()) is in the user's order.
  [[nodiscard]] ConstNodeMap positions() const noexcept;   // m
  [[nodiscard]] ConstNodeMap velocities() const noexcept;  // m/s
  // Net force of springs and loads on each node, N, without constraint forces. Evaluated on demand if the integrator
  // did not compute it, as after single sweeps.
  [[nodiscard]] ConstNodeMap forces() const;
  [[nodiscard]] const std::vector<std::uint32_t>& columns() const noexcept;
  // reaction() of all nodes.
  [[nodiscard]] ConstNodeMap reactions() const;
  // A copy of one of these maps whose column k is the user's node k.
  [[nodiscard]] Eigen::Matrix3Xd in_user_order(const ConstNodeMap& map) const;

  [[nodiscard]] Vector3 position(NodeIndex node) const;
  [[nodiscard]] Vector3 velocity(NodeIndex node) const;
  [[nodiscard]] Vector3 force(NodeIndex node) const;
  // Reaction, N: the force that holds or moves a fixed node, or the force of surfaces, including friction, on a node in
  // contact; zero for a free node. Does not include rigid connections.
  [[nodiscard]] Vector3 reaction(NodeIndex node) const;
  // Force in a rigid connection at the present state, N; > 0 is tension. If connections are redundant, only their sum
  // is determined; this is the solution of least norm.
  [[nodiscard]] double rigid_force(RigidIndex rigid) const;

  // Planes and then instruments, numbered as they were added.
  [[nodiscard]] std::size_t surface_count() const noexcept;
  [[nodiscard]] const std::string& surface_name(std::size_t surface) const;
  // Present position and velocity of a plane's point or an instrument's first point; m, m/s.
  [[nodiscard]] Vector3 surface_position(std::size_t surface) const;
  [[nodiscard]] Vector3 surface_velocity(std::size_t surface) const;
  // Rotation since the start: a direction d of the surface is now surface_rotation() d. Spin: angular velocity, rad/s.
  [[nodiscard]] Eigen::Matrix3d surface_rotation(std::size_t surface) const;
  [[nodiscard]] Vector3 surface_spin(std::size_t surface) const;
  // Total force (N) and torque about surface_position() (N m) of the nodes in contact on the surface.
  [[nodiscard]] Vector3 surface_force(std::size_t surface) const;
  [[nodiscard]] Vector3 surface_torque(std::size_t surface) const;
  [[nodiscard]] std::size_t nodes_touching(std::size_t surface) const;
  // Contact impulses, N s: total so far of those by surfaces on the node, and by nodes on the surface. They account for
  // velocity jumps at impacts. In the recurrent network they also contain the difference, of the order of the step,
  // between the momentum transferred in a step and the reactions reported at its ends, so that momentum balances; for a
  // fixed or moved node likewise, with the force that holds it.
  [[nodiscard]] Vector3 contact_impulse(NodeIndex node) const;
  [[nodiscard]] Vector3 surface_impulse(std::size_t surface) const;
  // The surfaces that the node is in contact with.
  [[nodiscard]] std::vector<std::size_t> surfaces_of(NodeIndex node) const;
  [[nodiscard]] bool held(NodeIndex node) const;      // by a surface
  [[nodiscard]] bool touching(NodeIndex node) const;  // held by a surface, or sliding on one

  // Where bodies touch each other, or themselves.
  [[nodiscard]] std::vector<BodyTouch> body_touches() const;

  // Tension of a spring, N (0 for a removed one); whether it is still there.
  [[nodiscard]] double tension(SpringIndex spring) const;
  [[nodiscard]] bool alive(SpringIndex spring) const;
  // For all springs at once, [user's number], faster than one by one: tensions, N, and energies stored by their laws, J
  // (0 for removed springs; nan where the spring function has no energy). Replace the contents of `out`.
  void tensions(std::vector<double>& out) const;
  void spring_energies(std::vector<double>& out) const;
  // The same without a copy, valid until the simulation is advanced or changed.
  [[nodiscard]] ConstValueMap tensions() const;
  [[nodiscard]] ConstValueMap spring_energies() const;

  // Power that the laws of each spring, or of an element, dissipate at the present state, W: of a law with an energy E
  //   D = (Q - dE/dq) q' - dE/dz z',
  // with its force Q, invariant q, internal states z and their rates; of a viscosity function without an energy Q q',
  // and Q |v| where it acts along the relative velocity v. Below 0 only where a law adds power (SPRINGNET_ADDS_POWER).
  // 0 for removed ones; nan where the spring function has no energy, so that it is not known what of its power is
  // stored.
  void dissipations(std::vector<double>& out) const;
  [[nodiscard]] double element_dissipation(ElementIndex element) const;

  // Internal states of a spring, or an element: those of its spring function in the order in which the law declares
  // them, then those of its viscosity function. Empty if the laws have none. Those of a removed one stay as they were.
  [[nodiscard]] std::vector<double> internal_states(SpringIndex spring) const;
  [[nodiscard]] std::vector<double> element_internal_states(ElementIndex element) const;
  // What these are, in the same order.
  [[nodiscard]] std::vector<InternalState> internal_state_names(SpringIndex spring) const;
  [[nodiscard]] std::vector<InternalState> element_internal_state_names(ElementIndex element) const;

  // For an element: the present value of the invariant, in its unit; the generalised force Q (N m, N/m, Pa for an
  // angle, an area, a volume; the pressure of an enclosed volume is -Q), > 0 if it acts to reduce the invariant, 0 for
  // a removed element; whether it is still there.
  [[nodiscard]] double element_value(ElementIndex element) const;
  [[nodiscard]] double element_force(ElementIndex element) const;
  [[nodiscard]] bool element_alive(ElementIndex element) const;

  // Energies, J. Potential energy: laws that have one, and gravity relative to the origin.
  [[nodiscard]] double kinetic_energy() const;
  [[nodiscard]] double potential_energy() const;
  [[nodiscard]] Energies energies() const;
  // Of all springs and elements together: dissipations() where they are known, W; and their sum over time since the
  // start, J (nan unless SimulationOptions::dissipated_energy). Over each committed step it is
  //   (R0 + R1) (q1 - q0) / 2 - (dE/dz0 + dE/dz1) (z1 - z0) / 2,   R = Q - dE/dq,
  // for laws along the relative velocity the trapezoidal rule over the power: second order in the step, and bounded for
  // however stiff damping and relaxation. Where no loads, moved nodes, input signals, contacts, drag of neurons or
  // removed springs do work, kinetic_energy() + potential_energy() + dissipated_energy() is constant to the order of
  // the integrator, at most the second in the time step; that includes cvode, whose states between the ends of time
  // steps it does not see.
  [[nodiscard]] double dissipated_power() const;
  [[nodiscard]] double dissipated_energy() const noexcept;
  [[nodiscard]] Vector3 momentum() const;          // kg m/s
  [[nodiscard]] Vector3 angular_momentum() const;  // kg m^2/s about the origin

  // Sets a force on a node, N, in addition to the scene's loads, until it is set again.
  void set_force(NodeIndex node, const Vector3& force);
  void set_gravity(const Vector3& acceleration);
  // From now on a load of the network, by its number there, acts with this multiple of its forces, tractions and
  // pressures. Throw Error(input) if there is none, or the factor is not finite.
  void set_load_factor(std::size_t load, double factor);
  [[nodiscard]] double load_factor(std::size_t load) const;
  // From now on a surface has this coefficient of Coulomb friction. Throws Error(input) if there is none of this
  // number, if it is frictionless or holds nodes, or if the coefficient is below 0 or not finite.
  void set_friction(std::size_t surface, double coefficient);
  [[nodiscard]] Friction surface_friction(std::size_t surface) const;
  // From now on the input signal has this value, in the unit that laws declare, in place of its course: by its number
  // in the network, or its name. Throw Error(input) if there is none, or the value is out of the laws' bounds.
  void set_input(InputIndex input, double value);
  void set_input(std::string_view name, double value);
  // The present value of an input signal.
  [[nodiscard]] double input_value(InputIndex input) const;
  // Changes of the state by the embedding program. A position behind a plane is refused (Error(input)). A velocity away
  // from the surface releases a held node; any other leaves it held, at rest.
  void set_position(NodeIndex node, const Vector3& position);
  void set_velocity(NodeIndex node, const Vector3& velocity);
  void set_fixed(NodeIndex node, bool fixed);  // fixed: where it is now, velocity zero
  // Remove springs: those listed, or those that cross a planar polygon (three corners or more). Return how many were
  // removed; springs removed before are ignored. Elements that contain both ends of a removed spring are removed with
  // it; a polygon also removes those that it crosses between two of their nodes. An enclosed volume is removed as a
  // whole with a side of one of its triangles: it leaks.
  std::size_t cut(const std::vector<SpringIndex>& springs);
  std::size_t cut_polygon(const std::vector<Vector3>& corners);

  // Returns how many were removed.
  std::size_t remove_elements(const std::vector<ElementIndex>& elements);
  // A removed node keeps its number and its place; its springs, elements and faces are removed, and it is fixed.
  // Throws Error(input) for a node with a rigid connection.
  void remove_nodes(const std::vector<NodeIndex>& nodes);

  // Changes of laws, neurons and rest states, which cost about as much as what they change. `values`: one for all, or
  // one each, in the units in which they are declared. The law is the spring's spring function or viscosity function
  // (ComponentKind). An input set here no longer follows its signal. Integrators go on from the state as it is: cvode
  // restarts, the others evaluate it anew. Throw Error(input), before anything is changed, for what does not exist or
  // is out of the declared bounds.
  void set_parameter(const std::vector<SpringIndex>& springs, ComponentKind law, std::string_view parameter,
                     const std::vector<double>& values);
  void set_element_parameter(const std::vector<ElementIndex>& elements, ComponentKind law, std::string_view parameter,
                             const std::vector<double>& values);
  void set_neuron_parameter(const std::vector<NodeIndex>& nodes, std::string_view parameter,
                            const std::vector<double>& values);
  void set_law_input(const std::vector<SpringIndex>& springs, ComponentKind law, std::string_view input,
                     const std::vector<double>& values);
  void set_element_input(const std::vector<ElementIndex>& elements, ComponentKind law, std::string_view input,
                         const std::vector<double>& values);
  void set_rest_lengths(const std::vector<SpringIndex>& springs, const std::vector<double>& values);  // m
  // Not of elements whose laws read several scalars.
  void set_references(const std::vector<ElementIndex>& elements, const std::vector<double>& values);
  void set_masses(const std::vector<NodeIndex>& nodes, const std::vector<double>& values);  // kg
  // The present values.
  [[nodiscard]] double parameter(SpringIndex spring, ComponentKind law, std::string_view parameter) const;
  [[nodiscard]] double element_parameter(ElementIndex element, ComponentKind law, std::string_view parameter) const;
  [[nodiscard]] double neuron_parameter(NodeIndex node, std::string_view parameter) const;
  [[nodiscard]] double rest_length(SpringIndex spring) const;
  [[nodiscard]] double reference(ElementIndex element) const;
  [[nodiscard]] double mass(NodeIndex node) const;
  // Adds nodes, springs, elements, bodies, loads, planes, instruments, …: `add` gets the network with its nodes where
  // they are now, in which rest lengths and references are those of the present state unless given, and may call all of
  // its functions that add something. Numbers go on from those before; what is there stays as it is, states of laws,
  // contacts and motions included. Surfaces are numbered planes first: where a plane is added, instruments
  // move up by one. Sets the engine up anew, which takes as long as a new simulation; the integrator begins anew.
  // Throws as Simulation(), what `add` throws, and Error(input) if it changes what is there; the simulation then stays
  // as it was.
  void extend(const std::function<void(Network&)>& add);
  // Goes on with another integrator, or with other parameters of the same, from the present state.
  void set_integrator(const LawUse& integrator);
  // The network as it is now: positions, velocities, parameters, rest lengths; without removed springs, elements and
  // torn faces, so that these have other numbers. Time starts at 0 in it: loads, motions, signals, cuts and changes are
  // shifted, what is over is left out, set_force() becomes a load, laws that read the time begin again. With it a
  // simulation starts where this one is, but for contacts and states of laws.
  [[nodiscard]] Network present_network() const;

  // What is where. Springs and elements of a node: those that are not removed, in rising order. Nearest, ray: at the
  // present state, by going through all (10^6 nodes: 1 ms, 3 10^6 springs: 14 ms, 10^5 faces: 2 ms); throw Error(input)
  // for numbers that are not finite and a direction of length 0. The first call of springs_of() lists those of all
  // nodes.
  [[nodiscard]] std::vector<SpringIndex> springs_of(NodeIndex node) const;
  [[nodiscard]] std::vector<ElementIndex> elements_of(NodeIndex node) const;
  [[nodiscard]] std::optional<NodeIndex> nearest_node(const Vector3& point) const;
  [[nodiscard]] std::optional<NearestSpring> nearest_spring(const Vector3& point) const;
  [[nodiscard]] std::optional<RayHit> cast_ray(const Vector3& origin, const Vector3& direction) const;
  // Of the integrator, rule by rule, at the present state; empty if it tells none. Sets up a second engine, so that
  // this one keeps its bits, and takes as long as the integrator's search: minutes for recurrent and 10^6 nodes.
  [[nodiscard]] std::vector<TimeStepLimit> time_step_limits() const;

  // Moves the surface, or the node (fixed from then on), in a straight line at constant speed to `position` (m), where
  // it arrives at `time` (s, later than now) and stays. Ends a motion of the scene; a surface that turns keeps turning.
  // For tracked tools: call it before each step with the place at the end of the step. The velocity changes when the
  // next step begins, to that told by then: tools do not stop at the end of each step (but where the velocity of a
  // motion of the scene jumps within it, too). In `recurrent` nodes lose contact with a tool that becomes slower only
  // if nothing presses them against it over the step.
  void move_surface(std::size_t surface, const Vector3& position, double time);
  void move_node(NodeIndex node, const Vector3& position, double time);

  // The local force model of a fixed or moved node, or of a surface: its force now, and the change of that force at the
  // end of a backward Euler step of `over` seconds (0: the time step) had it arrived elsewhere, with all else in
  // contact as it is, and bodies exerting the same forces on each other: the Schur complement of the step's linear
  // system, for `recurrent` with theta = 1 (its accuracy: propagation.md). A long `over` gives the stiffness at rest, a
  // short one that of the nearest springs and dampers. It is symmetric where forces have a potential and no friction
  // acts; it need not be definite. The motion of the network does not change. Costs about as much as a step. Throws
  // Error(input) for a free node, a surface that does not exist, an `over` below 0, above 1e100 s or not a number;
  // Error(simulation) if a law has no derivatives or the systems cannot be solved, as where the network buckles.
  [[nodiscard]] LocalForce local_force(NodeIndex node, double over = 0.0);
  [[nodiscard]] LocalForce local_surface_force(std::size_t surface, double over = 0.0);

  // All events so far, in order.
  [[nodiscard]] const std::vector<Event>& events() const noexcept;
  // Numbers that the integrator reports: evaluations, factorisations, …
  [[nodiscard]] const std::map<std::string, double>& statistics() const noexcept;
  // Notes for the user, in plain sentences, on decisions of the engine or the integrator: the update rule chosen, …
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept;

 private:
  struct SPRINGNET_LOCAL Impl;
  SPRINGNET_LOCAL explicit Simulation(std::unique_ptr<Impl> impl);
  struct SPRINGNET_LOCAL OtherThreads;
  std::unique_ptr<Impl> impl_;
  std::unique_ptr<const OtherThreads> others_;
};

}  // namespace springnet
