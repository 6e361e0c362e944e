// A network in motion.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <springnet/instruction_set.hpp>
#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet {

struct SimulationOptions {
  double time_step = 0.01;  // s: the paper's time constant t_c
  LawUse integrator{"recurrent", {}};
  unsigned threads = 0;  // 0: as many as the machine has and the size of the network is worth. 1: starts no thread.
  InstructionSet instruction_set = InstructionSet::best;
  bool renumber = true;  // false: node k of the user is column k of positions()
};

enum class Outcome { settled, oscillating, out_of_sweeps, diverging };
[[nodiscard]] std::string_view name_of(Outcome outcome) noexcept;  // "settled", "oscillating", "out of sweeps", …

// How the steps of the last call of step() or advance_to() went.
struct StepReport {
  Outcome outcome = Outcome::settled;  // settled if all of them did, else that of the last one that did not
  std::uint64_t steps = 0;             // committed
  std::uint64_t sweeps = 0;            // or evaluations of all springs
  double force_difference = 0.0;       // N; nan where not compared: exactly one sweep was asked for
  double residual = 0.0;               // N; nan where not evaluated
  NodeIndex node = 0;                  // with the greatest force difference
  std::int64_t start_node = -1;        // where the last sweep started; -1: it has no start
  std::uint64_t substeps = 0;          // smaller steps made in place of time steps that did not settle
  std::uint64_t stages = 0;            // smaller time constants passed on the way to the full one
};

// Something that happened to a spring, an element or a node.
struct Event {
  // jammed: a node in contact that no finite force can keep from going into the surface (Painlevé) is stopped at once.
  enum class Kind { cut, ruptured, touched, released, slipped, stuck, jammed };
  Kind kind;
  double time;  // s
  // Spring or element (cut, ruptured) or node (touched, released, jammed; slipped, stuck: Coulomb friction).
  std::uint32_t index;
  bool element = false;  // cut or ruptured, by its own law or because a spring between its nodes was: an element
  // Of a node: the surface (planes, then instruments; -1: not known), and the impulse that it gave the node, N s.
  std::int32_t surface = -1;
  Vector3 impulse = Vector3::Zero();
};

// Positions and so on without a copy: 3 x nodes, one row a coordinate, in the engine's order of nodes.
using ConstNodeMap =
    Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>, 0, Eigen::OuterStride<>>;

class Simulation {
 public:
  // Throws Error(input) or Error(plugin). `plugins` may be shared between simulations.
  Simulation(const Network& network, std::shared_ptr<const PluginHost> plugins, const SimulationOptions& options = {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  // One time step. Throws Error(simulation) if it does not settle and the integrator's policy is `error`, or if a
  // number is not finite; the state is then the last one that was reached: that before the step, or, with an integrator
  // that stops at events, that of the last event within it. time() tells.
  const StepReport& step();
  // Steps until `time`, the last one shortened to end there.
  const StepReport& advance_to(double time);

  [[nodiscard]] double time() const noexcept;
  [[nodiscard]] double time_step() const noexcept;
  [[nodiscard]] std::uint64_t steps() const noexcept;   // since the beginning
  [[nodiscard]] std::uint64_t sweeps() const noexcept;  // since the beginning
  [[nodiscard]] std::size_t node_count() const noexcept;
  [[nodiscard]] std::size_t spring_count() const noexcept;  // as the user added them, removed ones included
  [[nodiscard]] std::size_t live_spring_count() const noexcept;
  [[nodiscard]] std::size_t element_count() const noexcept;  // likewise
  [[nodiscard]] unsigned threads() const noexcept;
  [[nodiscard]] InstructionSet instruction_set() const noexcept;
  [[nodiscard]] const StepReport& last_report() const noexcept;

  // Valid until the simulation is advanced or changed. Column columns()[k] belongs to the user's node k;
  // positions()(Eigen::all, columns()) is the user's order.
  [[nodiscard]] ConstNodeMap positions() const noexcept;   // m
  [[nodiscard]] ConstNodeMap velocities() const noexcept;  // m/s
  // Net force of springs and loads on each node, without what holds it; N. Evaluated when asked for where the
  // integrator did not leave it, as after single sweeps.
  [[nodiscard]] ConstNodeMap forces() const;
  [[nodiscard]] const std::vector<std::uint32_t>& columns() const noexcept;

  [[nodiscard]] Vector3 position(NodeIndex node) const;
  [[nodiscard]] Vector3 velocity(NodeIndex node) const;
  [[nodiscard]] Vector3 force(NodeIndex node) const;
  // The force that holds or moves a fixed node, or that a surface puts on one in contact, friction included; zero for a
  // free one. Rigid connections at the node are not part of it. N
  [[nodiscard]] Vector3 reaction(NodeIndex node) const;
  // Force in a rigid connection at the present state, > 0 is tension. Where connections are redundant only their sum is
  // determined; this is the smallest set. N
  [[nodiscard]] double rigid_force(RigidIndex rigid) const;

  // Planes and then instruments, numbered as they were added.
  [[nodiscard]] std::size_t surface_count() const noexcept;
  [[nodiscard]] const std::string& surface_name(std::size_t surface) const;
  // A plane's point, an instrument's first point, now. m, m/s
  [[nodiscard]] Vector3 surface_position(std::size_t surface) const;
  [[nodiscard]] Vector3 surface_velocity(std::size_t surface) const;
  // How it has turned since the start: a direction d of it is now surface_rotation() d. rad/s, about an axis in space.
  [[nodiscard]] Eigen::Matrix3d surface_rotation(std::size_t surface) const;
  [[nodiscard]] Vector3 surface_spin(std::size_t surface) const;
  // What the nodes in contact do to the surface together: force N, torque about surface_position() N m.
  [[nodiscard]] Vector3 surface_force(std::size_t surface) const;
  [[nodiscard]] Vector3 surface_torque(std::size_t surface) const;
  [[nodiscard]] std::size_t nodes_touching(std::size_t surface) const;
  // Impulses of touching: velocities jump where nodes meet surfaces, by more than the forces explain. Sums of those
  // that surfaces gave the node, and that nodes gave the surface, so far. N s. In the network also what the reactions
  // that are told at the ends of a step do not explain of it, of the order of the step, so that momentum balances; that
  // of a node that is fixed or moved is what holds it.
  [[nodiscard]] Vector3 contact_impulse(NodeIndex node) const;
  [[nodiscard]] Vector3 surface_impulse(std::size_t surface) const;
  // The surfaces that the node is in contact with.
  [[nodiscard]] std::vector<std::size_t> surfaces_of(NodeIndex node) const;
  [[nodiscard]] bool held(NodeIndex node) const;      // by a surface
  [[nodiscard]] bool touching(NodeIndex node) const;  // held by a surface, or sliding on one

  // Tension of a live spring, N (0 for a removed one); and whether it is there.
  [[nodiscard]] double tension(SpringIndex spring) const;
  [[nodiscard]] bool alive(SpringIndex spring) const;
  // The same of all springs, by the user's number, faster than one by one: tensions N, and what their spring functions
  // have stored, J (0 for removed springs; nan for laws without an energy). Replace what is in the vector.
  void tensions(std::vector<double>& out) const;
  void spring_energies(std::vector<double>& out) const;

  // Of an element: the invariant now, in its unit; the law's answer Q, > 0 where it pulls the invariant down (N m, N/m,
  // Pa for an angle, an area, a volume: a filling's pressure is -Q), 0 for a removed one; and whether it is there.
  [[nodiscard]] double element_value(ElementIndex element) const;
  [[nodiscard]] double element_force(ElementIndex element) const;
  [[nodiscard]] bool element_alive(ElementIndex element) const;

  // J. Potential energy counts the laws that have one, and gravity from the origin.
  [[nodiscard]] double kinetic_energy() const;
  [[nodiscard]] double potential_energy() const;
  [[nodiscard]] Vector3 momentum() const;          // kg m/s
  [[nodiscard]] Vector3 angular_momentum() const;  // kg m^2/s about the origin

  // A force on a node on top of the scene's loads, from now on until it is set again. N
  void set_force(NodeIndex node, const Vector3& force);
  void set_gravity(const Vector3& acceleration);
  // Changes of the state by the embedding program. A position behind a plane is refused (Error(input)). A velocity that
  // lifts a node held by a contact releases it; any other leaves it held, at rest.
  void set_position(NodeIndex node, const Vector3& position);
  void set_velocity(NodeIndex node, const Vector3& velocity);
  void set_fixed(NodeIndex node, bool fixed);  // fixed: where it is now, velocity zero
  // Remove springs: those listed, or those that cross a planar polygon (three corners or more). Return how many were
  // removed; those that were out already do not matter. With a spring go the elements that have both its ends; with a
  // polygon also those that it crosses between two of their nodes. An enclosed volume goes as a whole when a side of
  // one of its triangles does: the filling leaks.
  std::size_t cut(const std::vector<SpringIndex>& springs);
  std::size_t cut_polygon(const std::vector<Vector3>& corners);

  // From now on the surface, or the node (fixed from then on), moves straight and evenly to `position`, where it
  // arrives at `time` (above now) and stays: how a host hands on what a tracked tool does. A motion of the scene ends;
  // a surface that turns goes on turning.
  void move_surface(std::size_t surface, const Vector3& position, double time);
  void move_node(NodeIndex node, const Vector3& position, double time);

  // Everything that happened so far, in order.
  [[nodiscard]] const std::vector<Event>& events() const noexcept;
  // Numbers that the integrator reports: evaluations, factorisations, …
  [[nodiscard]] const std::map<std::string, double>& statistics() const noexcept;
  // What the engine or the integrator decided that the user should know, in plain sentences: the update rule chosen, …
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace springnet
