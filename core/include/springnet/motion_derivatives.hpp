// Learning from motion: how a trajectory of the recurrent network depends on masses, parameters of laws and neurons,
// rest lengths and the start. A step is a fixed point, so it is differentiated implicitly (Pineda, Phys. Rev. Lett. 59,
// 1987): with h the time constant, w = theta h and c = (1 - theta) h,
//
//   U = v + c a(p, v) + w a(P, U),   P = p + c v + w U
//
// the derivatives of a step solve one linear system with A = I - w da/dv - w^2 da/dp at its end, forwards (tangent), or
// with the transposed matrix backwards (adjoint), whatever the update rule that found P and U.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <springnet/export.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// Values of one kind, one for each member (initial_velocity: three, x y z of the first node, then of the next).
struct LearnedValues {
  enum class Kind : std::uint8_t {
    spring_parameter,     // of the spring functions of springs, or elements
    viscosity_parameter,  // of their viscosity functions
    rest_length,          // m, of springs; references of elements
    mass,                 // kg, of nodes
    neuron_parameter,     // of the neurons of nodes
    initial_velocity,     // m/s, of nodes
    load,                 // factors of loads of the network, which multiply their forces, tractions and pressures
    gravity,              // m/s^2, components of its acceleration; a member is an axis: 0, 1 or 2
    friction              // coefficients of surfaces with Coulomb friction: planes, then instruments
  };
  Kind kind = Kind::spring_parameter;
  bool of_elements = false;            // in place of springs
  std::string parameter;               // its name; of masses, rest lengths and velocities: empty
  std::vector<std::uint32_t> members;  // springs, elements, nodes, loads, axes or surfaces: the user's numbers
};

// "spring", "viscosity", "rest_length", "mass", "neuron", "velocity", "load", "gravity", "friction"
[[nodiscard]] SPRINGNET_API std::string_view name_of(LearnedValues::Kind kind) noexcept;
// "node", "spring", "element", "load", "surface" or, of gravity, "axis"
[[nodiscard]] SPRINGNET_API std::string_view member_name(LearnedValues::Kind kind, bool of_elements) noexcept;

// One trajectory and its derivatives. The integrator is `recurrent`, with any update rule and theta. Steps are those of
// SimulationOptions::time_step. With events = "located" the times at which springs break, nodes touch, slip and leave
// surfaces move with the values, and that is part of the derivatives. Without, they are those of motions in which the
// same happens in the same steps. Refused with a message are changes at times of the integrator, of inputs of laws and
// such as remove nodes, steps that were divided as they did not settle, nodes that are jammed, rigid connections that
// join more than 100 nodes, or more than 40 while some touch, and some located events (core/docs/learning.md).
class SPRINGNET_API MotionDerivatives {
 public:
  // duration: s, a whole number of time steps is made, at least one. Throws as Simulation(), and Error(input) for an
  // integrator, a net or values that cannot be differentiated.
  MotionDerivatives(const std::shared_ptr<const Network>& network, const std::shared_ptr<const PluginHost>& plugins,
                    const SimulationOptions& options, double duration, std::vector<LearnedValues> learned);
  ~MotionDerivatives();
  MotionDerivatives(MotionDerivatives&&) noexcept;
  MotionDerivatives& operator=(MotionDerivatives&&) noexcept;
  MotionDerivatives(const MotionDerivatives&) = delete;
  MotionDerivatives& operator=(const MotionDerivatives&) = delete;

  // Of all LearnedValues, one after another.
  [[nodiscard]] std::size_t value_count() const noexcept;
  [[nodiscard]] Eigen::VectorXd values_of_network() const;

  // Simulates with these values. Throws Error(input) for values that are refused (a mass of 0, …), Error(simulation) if
  // a step fails, or has what cannot be differentiated; there is then no trajectory.
  void run(const Eigen::VectorXd& values);

  // What happened in the last run: cuts, ruptures, contacts.
  [[nodiscard]] std::vector<Event> events() const;

  // Bytes that the states of the runs to come may take [1 GiB], those at located events among them. If not all fit,
  // some are kept together with saved states of the simulation, and the others are made again, with the same bits,
  // where they are asked for: by adjoint() in the order of binomial checkpoints (revolve), by tangent(), positions()
  // and velocities() once if they are asked for in rising order. run() throws Error(input) that tells the least if it
  // is too little: at once, or where so many events have been located that it is.
  void set_memory(std::size_t bytes);
  // Of the last run, and since.
  struct Kept {
    std::size_t states, saved;  // at most at a time; saved: states of the simulation
    std::size_t part;           // states that are made again together
    std::size_t places;         // for saved states; 0: all states are kept
    std::size_t steps_again;    // made once more so far
    std::size_t bytes;          // of states and saved ones, at most at a time
  };
  [[nodiscard]] Kept kept() const noexcept;

  // Of the linear systems of derivatives, relative to their right-hand sides [1e-10]: derivatives are good to about
  // this, times how much a disturbance grows in the steps that follow. Throws Error(input) unless it is between 0
  // and 1.
  void set_accuracy(double relative);

  // Of the last run: states 0 (the start) to step_count().
  [[nodiscard]] std::size_t step_count() const noexcept;
  [[nodiscard]] double time(std::size_t state) const;
  // m and m/s, [3][node] in the user's order.
  [[nodiscard]] Eigen::Matrix3Xd positions(std::size_t state) const;
  [[nodiscard]] Eigen::Matrix3Xd velocities(std::size_t state) const;

  // How far a state may be from that of steps that are settled exactly: what steps have left unbalanced moves the
  // lightest node, and nothing brings it back. m, m/s.
  struct Settled {
    double position = 0.0, velocity = 0.0;
  };
  [[nodiscard]] Settled settled_to(std::size_t state) const;

  // Forwards: how each state changes with the values. Each column of `changes` is a change of all of them; the columns
  // that are told have the change of the positions, and of the velocities, [3 node] as x y z of node 0, of node 1, …
  // The linear system of a step is prepared once for all columns.
  using StateTangents =
      std::function<void(std::size_t state, const Eigen::MatrixXd& positions, const Eigen::MatrixXd& velocities)>;
  void tangent(const Eigen::MatrixXd& changes, const StateTangents& told);

  // Derivatives of a loss by a state, [3][node] in the user's order.
  struct StateChange {
    Eigen::Matrix3Xd positions, velocities;
  };
  // Backwards: dL/d(values) of a loss L of the states. `add` adds the derivatives of L by a state to zeros, from the
  // last state to the first. Costs one transposed solve for each step, however many values there are.
  [[nodiscard]] Eigen::VectorXd adjoint(const std::function<void(std::size_t state, StateChange&)>& add);

  // Real-time recurrent learning (Williams and Zipser, Neural Computation 1, 1989): step by step, with changes of the
  // states for `changes` of the values carried along, 6 node numbers for each column. States 0 and 1 are then the start
  // and the end of the step that was made last; before one is made, both are the start. Throws as run().
  void begin_steps(const Eigen::VectorXd& values, const Eigen::MatrixXd& changes);
  // values: with which this step is made; `changes` at them.
  void make_step(const Eigen::VectorXd& values, const Eigen::MatrixXd& changes);
  // Of state 0 or 1, as tangent() tells them.
  void step_tangents(std::size_t state, Eigen::MatrixXd& positions, Eigen::MatrixXd& velocities) const;

 private:
  struct SPRINGNET_LOCAL Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace springnet
