// Observations of one experiment as residuals of its simulated motion: weighted differences, and their derivatives.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <springnet/motion_derivatives.hpp>
#include <springnet/observations.hpp>

namespace springnet::learning {

// Between the states of a motion, positions are cubic Hermite splines of positions and velocities, velocities their
// derivatives: of third order, where a step is of second at most.
class ObservedMotion {
 public:
  // Throws Error(input) for kinds of observations that are not learned from. state_times: s, ascending, from before the
  // first observation to after the last one.
  ObservedMotion(const Observations& observations, const std::vector<double>& state_times);

  // Of each component of a vector, each distance; what is missing leaves 0.
  [[nodiscard]] Eigen::Index count() const noexcept { return count_; }
  // sqrt(weight) (simulated - observed), with 1/2 |r|^2 the loss. The derivatives below are those at this motion.
  void residuals(const MotionDerivatives& motion, Eigen::Ref<Eigen::VectorXd> out);
  // Adds the changes of residuals for those of a state, a column each; see MotionDerivatives::tangent().
  void add_tangent(std::size_t state, const Eigen::MatrixXd& positions, const Eigen::MatrixXd& velocities,
                   Eigen::Ref<Eigen::MatrixXd> out) const;
  // Adds derivatives of weights . residuals by a state.
  void add_adjoint(std::size_t state, const Eigen::Ref<const Eigen::VectorXd>& weights,
                   MotionDerivatives::StateChange& to) const;

 private:
  // At a time the vector of a node is p[0] x + v[0] x' of a state and p[1] x + v[1] x' of the next one.
  struct Between {
    std::size_t state = 0;
    double p[2] = {}, v[2] = {};  // of velocities in 1/s and 1
  };
  struct Row {
    bool is_distance;
    NodeIndex node, other;
    Between at;
    Vector3 observed, root_weight;  // of distances: the first component
    Vector3 direction;              // of distances: from `other` to `node`
    Eigen::Index first;             // of its residuals
  };
  void add(const Row& row);

  std::vector<Row> rows_;
  std::vector<std::vector<std::size_t>> of_state_;  // [state]: rows between it and the next one
  Eigen::Index count_ = 0;
};

}  // namespace springnet::learning
