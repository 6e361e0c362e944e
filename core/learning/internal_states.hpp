// The internal states of laws in the steps of a motion, and in their derivatives. A step eliminates them: with z at its
// start, and q and u the invariants that laws read and their rates,
//
//   U = v + c a(p, v, z) + w a(P, U, Z),   Z = Z(q(P), u(P, U); z, q(p), u(p, v))
//
// The host's derivatives of accelerations at the end of a step are total by P, U and parameters, with the Z that
// follows. What is left is here: how accelerations and Z change with the start, and Z with P and U.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <springnet/sdk/host.hpp>
#include <springnet/simulation.hpp>

#include "layers/linear/state_step.hpp"
#include "learning/learned_values.hpp"
#include "simulation/engine.hpp"

namespace springnet::learning {

// Vectors of all nodes and states have the engine's order. Without states all of this does nothing.
class InternalStates {
 public:
  InternalStates(Engine& engine, double theta);

  [[nodiscard]] bool any() const noexcept { return count_ > 0; }
  // Throws Error(input) if those with which laws begin follow from what is learned: the motions begin with the states
  // of the network. values: of the network.
  void check_start(const LearnedSets& learned, const Eigen::VectorXd& values);
  // The present ones of a simulation of this network.
  void record(const Simulation& simulation, Eigen::VectorXd& z) const;

  // For evaluations at the end of a step that starts here: call it before begin_step().
  void start_at(const springnet_evaluation& start, const Eigen::VectorXd& z);
  // What such an evaluation asks for, s; and one of accelerations with the states as they are. Null: there are none.
  // Valid until the next call of the same function.
  [[nodiscard]] const springnet_internal* stepped(double time_step);
  [[nodiscard]] const springnet_internal* as_they_are(const Eigen::VectorXd& z);
  // Those at the end of a step of this length, of the host of the engine; empty: there are none.
  [[nodiscard]] Eigen::VectorXd at_end(const sdk::Host& host, springnet_evaluation end, double time_step);
  // By the time, of the nodes and of laws, at the state where the step has begun; the nodes have these accelerations.
  [[nodiscard]] Eigen::VectorXd rates(const sdk::Host& host, const springnet_evaluation& start,
                                      const Eigen::VectorXd& accelerations, double short_time);
  [[nodiscard]] Eigen::Index count() const noexcept { return count_; }

  // Those below are called at an evaluation at which the host was linearised. Throw Error(simulation) if a law fails.

  // Forwards: changes of the states, of 0 at first, are kept along with those of the nodes, a column each. With the
  // states as they are, accelerations += weight da/dz dz;
  void begin_changes(Eigen::Index columns);
  // More columns, of 0, or fewer.
  void resize_changes(Eigen::Index columns);
  [[nodiscard]] Eigen::MatrixXd::ColXpr change(Eigen::Index column) { return changes_.col(column); }
  void add_accelerations(const springnet_evaluation& at, double weight, Eigen::MatrixXd& accelerations);
  // at the end of a step += weight times what changes of its start, dp, dv and dz, make of them;
  void add_by_start(const springnet_evaluation& start, const springnet_evaluation& end, double weight,
                    const Eigen::MatrixXd& dp, const Eigen::MatrixXd& dv, Eigen::MatrixXd& accelerations);
  // then changes of the states by the values are written here (null: there are no states),
  [[nodiscard]] double* by_values(Eigen::Index column);
  // and with those of the nodes at the end the step is complete.
  void end_step(const springnet_evaluation& end, const Eigen::MatrixXd& dp, const Eigen::MatrixXd& dv);

  // Backwards: derivatives of a loss by the states, of 0 at first, likewise. From those by the end of a step: dp and dv
  // += what they are by the nodes there;
  void begin_weights();
  void weigh_end(const springnet_evaluation& end, Eigen::VectorXd& dp, Eigen::VectorXd& dv);
  // the present ones, for those by values; null: there are no states;
  [[nodiscard]] double* weights() noexcept { return any() ? weights_.data() : nullptr; }
  [[nodiscard]] Eigen::VectorXd& all_weights() noexcept { return weights_; }
  // to those by its start, with weights of the accelerations at its end; dp and dv += what the start has in both.
  void weigh_start(const springnet_evaluation& start, const springnet_evaluation& end,
                   const Eigen::VectorXd& accelerations, Eigen::VectorXd& dp, Eigen::VectorXd& dv);
  // += (da/dz)^T accelerations, with the states as they are: those, or some of other numbers by the states.
  void weigh_accelerations(const springnet_evaluation& at, const Eigen::VectorXd& accelerations) {
    weigh_accelerations(at, accelerations, weights_);
  }
  void weigh_accelerations(const springnet_evaluation& at, const Eigen::VectorXd& accelerations, Eigen::VectorXd& to);
  // += derivatives of the margin of a rupture, an event of the host's.
  void add_margin(const springnet_evaluation& at, std::uint32_t event, Eigen::VectorXd& to);

 private:
  struct Place {
    std::uint32_t member;
    std::uint64_t first, pitch, count;  // of its states
  };
  [[nodiscard]] Eigen::VectorXd at_start();
  // What has the first that two lists differ in, "spring 3"; empty: nothing has.
  [[nodiscard]] std::string difference(const Eigen::VectorXd& one, const Eigen::VectorXd& other) const;
  void find(const springnet_evaluation& at);  // the laws' derivatives
  [[nodiscard]] layers::NodeArrays nodes_of(const springnet_evaluation& at) const noexcept;
  void accelerations_of_force();                        // acceleration_, with what constraints make of it
  void force_of(const Eigen::VectorXd& accelerations);  // force_ = (da/dF)^T accelerations, likewise

  Engine& engine_;
  std::uint32_t order_;  // of the steps
  Eigen::Index count_ = 0;
  std::vector<Place> springs_, elements_;
  layers::StateStep step_;
  springnet_internal stepped_{}, as_they_are_{};
  Eigen::MatrixXd changes_, by_values_;
  Eigen::VectorXd weights_;
  Eigen::VectorXd force_, acceleration_, q_, u_, next_;
};

}  // namespace springnet::learning
