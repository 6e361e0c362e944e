// Observations of one experiment as residuals of its simulated motion: weighted differences, and their derivatives.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <springnet/motion_derivatives.hpp>
#include <springnet/observations.hpp>

#include "learning/between_states.hpp"
#include "learning/observed_net.hpp"
#include "learning/observed_reactions.hpp"
#include "learning/observed_surface.hpp"

namespace springnet::learning {

// Positions, velocities and distances of nodes; then points of the surface, and reactions.
class ObservedMotion {
 public:
  // Throws Error(input) for reactions of nodes that have none. state_times: s, ascending, from before the first
  // observation to after the last one. The net must outlive it.
  ObservedMotion(const Observations& observations, const std::vector<double>& state_times, ObservedNet& net);

  // Of each component of a vector, each distance, each component of the way to a point of the surface; what is missing
  // leaves 0.
  [[nodiscard]] Eigen::Index count() const noexcept;
  // How far what was observed of nodes is from where the network starts, at rest: root of the sum of weighted squares.
  [[nodiscard]] double extent(const Network& network) const;
  // sqrt(weight) (simulated - observed), with 1/2 |r|^2 the loss. values: those of the motion. The derivatives below
  // are those at this motion.
  void residuals(const MotionDerivatives& motion, const Eigen::VectorXd& values, Eigen::Ref<Eigen::VectorXd> out);
  // Changes of the values, and of a state for them, a column each; see MotionDerivatives::tangent().
  struct Tangents {
    const Eigen::MatrixXd &values, &positions, &velocities;
  };
  // Adds the changes of residuals.
  void add_tangent(const MotionDerivatives& motion, std::size_t state, const Tangents& changes,
                   Eigen::Ref<Eigen::MatrixXd> out) const;
  // Adds derivatives of weights . residuals by a state, and direct ones by the values.
  void add_adjoint(const MotionDerivatives& motion, std::size_t state, const Eigen::Ref<const Eigen::VectorXd>& weights,
                   MotionDerivatives::StateChange& to, Eigen::VectorXd& by_values) const;

 private:
  struct Row {
    bool is_distance;
    NodeIndex node, other;
    Between at;
    Vector3 observed, root_weight;  // of distances: the first component
    Vector3 direction;              // of distances: from `other` to `node`
    Eigen::Index first;             // of its residuals
    bool may_be_outlier = false;    // a position
    Eigen::Matrix3d by_vector{};    // derivative of the residual, but of distances
  };
  void add(const Row& row);
  void set_residual(Row& row, const Vector3& simulated, Eigen::Ref<Eigen::VectorXd> out) const;
  void add_tangent_of_nodes(std::size_t state, const Tangents& changes, Eigen::Ref<Eigen::MatrixXd> out) const;
  void add_adjoint_of_nodes(std::size_t state, const Eigen::Ref<const Eigen::VectorXd>& weights,
                            MotionDerivatives::StateChange& to) const;

  double outlier_distance_;  // m
  std::vector<Row> rows_;
  std::vector<std::vector<std::size_t>> of_state_;  // [state]: rows between it and the next one
  Eigen::Index count_ = 0;                          // of the residuals of rows_
  std::optional<ObservedSurface> surface_;
  std::optional<ObservedReactions> reactions_;
};

}  // namespace springnet::learning
