// Forces that hold or move nodes, at the states of a motion, and their derivatives: directly by what is learned, and by
// the state. Together with MotionDerivatives they differentiate a loss of reactions.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <springnet/export.hpp>
#include <springnet/motion_derivatives.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet {

// The reaction of a node that is fixed or moved, of mass m, is R = m (a_given - a(p, v)): with a_given the acceleration
// of its motion (0: fixed), and a what its neuron would answer to springs, elements and loads if it were free. It is a
// function of one state, the same for every theta. As in reactions.csv of a run, and by Simulation::reaction(), loads
// that change are those averaged over the step that ends with the state; at the start, over the first step.
class SPRINGNET_API ReactionDerivatives {
 public:
  // Of the same network, options and values as the MotionDerivatives whose states it is given. Throws as Simulation(),
  // and Error(input) for nets with rigid connections or laws with internal states.
  ReactionDerivatives(const std::shared_ptr<const Network>& network, const std::shared_ptr<const PluginHost>& plugins,
                      const SimulationOptions& options, std::vector<LearnedValues> learned);
  ~ReactionDerivatives();
  ReactionDerivatives(ReactionDerivatives&&) noexcept;
  ReactionDerivatives& operator=(ReactionDerivatives&&) noexcept;
  ReactionDerivatives(const ReactionDerivatives&) = delete;
  ReactionDerivatives& operator=(const ReactionDerivatives&) = delete;

  // Whether the node is fixed or moved; the reactions of others are 0.
  [[nodiscard]] bool has_reaction(NodeIndex node) const;
  // Those of the motion. Throws as MotionDerivatives::run().
  void set_values(const Eigen::VectorXd& values);

  // N, [3][node]. This and the functions below throw Error(simulation) where laws do not answer, and for motions in
  // which springs break or are cut.
  [[nodiscard]] Eigen::Matrix3Xd at(const MotionDerivatives& motion, std::size_t state);
  // Forwards: changes of reactions, [3 node] as x y z of node 0, …, a column for each of `changes` of the values, with
  // those of the state as MotionDerivatives::tangent() tells them.
  [[nodiscard]] Eigen::MatrixXd tangent(const MotionDerivatives& motion, std::size_t state,
                                        const Eigen::MatrixXd& changes, const Eigen::MatrixXd& positions,
                                        const Eigen::MatrixXd& velocities);
  // Backwards, of a loss with these derivatives by the reactions, [3][node]: adds its derivatives by the state, for
  // MotionDerivatives::adjoint(), and its direct ones by the values, to be added to what that answers.
  void add_adjoint(const MotionDerivatives& motion, std::size_t state, const Eigen::Matrix3Xd& by_reaction,
                   MotionDerivatives::StateChange& to, Eigen::VectorXd& by_values);

 private:
  struct SPRINGNET_LOCAL Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace springnet
