// A penalty on motions that are not smooth: how much the accelerations of nodes change from one step to the next.
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include <springnet/motion_derivatives.hpp>

namespace springnet::learning {

// Residuals of each node at each state k between the first and the last, with the time step h and a deviation D, m/s^2:
//   (v_(k+1) - 2 v_k + v_(k-1)) / (h D)
// They are no observations, and say nothing of noise.
class Smoothness {
 public:
  // steps: of the motion; h: s.
  Smoothness(double deviation, std::size_t steps, double h, std::size_t nodes)
      : factor_(1.0 / (h * deviation)), steps_(steps), nodes_(static_cast<Eigen::Index>(nodes)) {}

  [[nodiscard]] Eigen::Index count() const noexcept {
    return steps_ < 2 ? 0 : 3 * nodes_ * static_cast<Eigen::Index>(steps_ - 1);
  }
  void residuals(const MotionDerivatives& motion, Eigen::Ref<Eigen::VectorXd> out) const;
  // Adds the changes of residuals for those of a state's velocities, [3 node] and a column each, and the transpose.
  void add_tangent(std::size_t state, const Eigen::MatrixXd& velocities, Eigen::Ref<Eigen::MatrixXd> out) const;
  void add_adjoint(std::size_t state, const Eigen::Ref<const Eigen::VectorXd>& weights,
                   MotionDerivatives::StateChange& to) const;

 private:
  // use(first row of a state's residuals, factor of these velocities in them).
  template <class Use>
  void for_each_row_of(std::size_t state, const Use& use) const;

  double factor_;  // 1/(m/s)
  std::size_t steps_;
  Eigen::Index nodes_;
};

}  // namespace springnet::learning
