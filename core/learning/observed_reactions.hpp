// Forces that were seen to hold or move nodes, as residuals of a simulated motion.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <springnet/observations.hpp>
#include <springnet/reaction_derivatives.hpp>

namespace springnet::learning {

// Reactions are known at states, see ReactionDerivatives; between them they are straight lines.
class ObservedReactions {
 public:
  // Throws Error(input) with the place of the row for a node that is neither fixed nor moved.
  ObservedReactions(ReactionDerivatives& reactions, const Observations& observations,
                    const std::vector<double>& state_times);

  [[nodiscard]] Eigen::Index count() const noexcept { return 3 * static_cast<Eigen::Index>(rows_.size()); }
  // As of ObservedMotion.
  void residuals(const MotionDerivatives& motion, const Eigen::VectorXd& values, Eigen::Ref<Eigen::VectorXd> out);
  void add_tangent(const MotionDerivatives& motion, std::size_t state, const Eigen::MatrixXd& changes,
                   const Eigen::MatrixXd& positions, const Eigen::MatrixXd& velocities,
                   Eigen::Ref<Eigen::MatrixXd> out) const;
  void add_adjoint(const MotionDerivatives& motion, std::size_t state, const Eigen::Ref<const Eigen::VectorXd>& weights,
                   MotionDerivatives::StateChange& to, Eigen::VectorXd& by_values) const;

 private:
  struct Row {
    NodeIndex node;
    Vector3 observed, root_weight;
  };
  // A row has this share of the reaction at a state.
  struct Share {
    std::size_t row;
    double share;
  };

  ReactionDerivatives& reactions_;
  std::vector<Row> rows_;
  std::vector<std::vector<Share>> of_state_;  // [state]
};

}  // namespace springnet::learning
